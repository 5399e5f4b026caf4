"""Cases of misuse of recordings: wrong layouts, values, files and readings of them."""

import zipfile

import numpy as np

from tests.cli.misuse.mistakes import (
    COLUMNS,
    LSB,
    ROWS,
    Misuse,
    array,
    extra,
    garble,
    header,
    lines,
    log,
    member,
    noise,
    nothing,
    put,
    raw,
    recorded,
    references,
    stuck,
    table,
    untared,
)

ESTIMATE = "estimate skin.toml wrong.{} --out r.npz"
NPY, NPZ, CSV, PARQUET, MCAP = (ESTIMATE.format(suffix) for suffix in ("npy", "npz", "csv", "parquet", "mcap"))
WRONG = "estimate wrong.toml frames.npz --out r.npz"
GOOD = "estimate skin.toml frames.npz --out r.npz"



LAYOUT = [
    Misuse("rows and columns exchanged", array(np.zeros((3, COLUMNS, ROWS))), NPY),
    Misuse("a transposed frame", array(np.zeros((COLUMNS, ROWS))), NPY),
    Misuse("times in an array", array(np.zeros((3, 31))), NPY),
    Misuse("frames along the last axis", array(np.zeros((ROWS, COLUMNS, 3))), NPY),
    Misuse("no frame", array(np.zeros((0, ROWS, COLUMNS))), NPY),
    Misuse("another sensor's frames", array(np.zeros((3, 4, 4))), NPY),
]

VALUES = [
    Misuse("NaN", array(np.full((1, ROWS, COLUMNS), np.nan)), NPY),
    Misuse("beyond any stress", array(np.full((1, ROWS, COLUMNS), 1e160)), NPY),
    Misuse("unsigned wrap", array(np.full((1, 5, 6), 2**64 - 1, np.uint64)), NPY),
    Misuse("complex stress", array(np.zeros((1, ROWS, COLUMNS)) * 1j), NPY),
    Misuse("complex reference", references(mu_ref=np.ones(3) * 1j), "verify skin.toml --frames wrong.npz"),
    Misuse("infinite reference", references(mu_ref=[0, 1, np.inf]), "verify skin.toml --frames wrong.npz"),
    Misuse("reference of text", references(phi_ref_deg=list("abc")), "verify skin.toml --frames wrong.npz"),
]

HEADERS = [
    Misuse("a shape of booleans", header("(True, 5, 6)"), NPY),
    Misuse("a shape beyond 2^64", header(f"({2**64}, 5, 6)"), NPY),
    Misuse("a shape beyond the file", header("(1000000000000, 5, 6)"), NPY),
    Misuse("Python objects", header("(1, 5, 6)", "'|O'"), NPY),
    Misuse("an unknown version", header("(1, 5, 6)", version=9), NPY),
    Misuse("a damaged LZMA member", member(garble, zipfile.ZIP_LZMA), NPZ),
    Misuse("a damaged deflate member", member(garble, zipfile.ZIP_DEFLATED), NPZ),
    Misuse("a wrong checksum", member(put(14, 7)), NPZ),
    Misuse("an encrypted member", member(put(6, 1)), NPZ),
    Misuse("an unknown compression", member(put(8, 99)), NPZ),
    Misuse("no key frames", lambda: np.savez("wrong.npz", stress=1), NPZ),
    Misuse("a mistaken suffix", raw("wrong.npy", b"PK\3\4" + bytes(99)), NPY),
]

TEXT = [
    Misuse("decimal commas", lines(",", point=","), CSV),
    Misuse("points and commas", lines(";", first="1,5" + ";1" * 29 + "\n"), CSV),
    Misuse("a column of times", lines(before="0.{},"), CSV),
    Misuse("times of the clock", lines("\t", before="12:30:0{}\t"), CSV),
    Misuse("times and numbers", lines(";", before="0.{0};{0};"), CSV),
    Misuse("nothing to skip", lines(), f"{CSV} --skip-columns 1"),
    Misuse("numbered headings", lines(first=",".join(map(str, range(30))) + "\n"), CSV),
    Misuse("a typo in the first line", lines(first="1.x" + ",1" * 29 + "\n"), CSV),
    Misuse("a digit of another script", lines(first="\u0661" + ",1" * 29 + "\n"), CSV),
    Misuse("an underscore", lines(first="1_000" + ",1" * 29 + "\n"), CSV),
    Misuse("UTF-16", raw("wrong.csv", "1,2\n".encode("utf-16")), CSV),
    Misuse("a megabyte in a cell", lines(first="y" * 1_000_000 + ",1" * 29 + "\n"), CSV),
    Misuse("an empty file", raw("wrong.csv", b""), CSV),
]

TABLES = [
    Misuse("text called Parquet", raw("wrong.parquet", b"1,2,3\n"), PARQUET),
    Misuse("text in Parquet", table({"note": ["a"]}), PARQUET),
    Misuse("a gap in Parquet", table({"skin": [[1.0] * 29 + [None]]}), PARQUET),
    Misuse("all columns skipped", table({"skin": [[1.0] * 30]}), f"{PARQUET} --skip-columns 1"),
    Misuse("text called MCAP", raw("wrong.mcap", b"1,2,3\n" * 9), MCAP),
    Misuse("a log without frames", log("std_msgs/msg/String", "/note"), MCAP),
    Misuse("no such topic", log("std_msgs/msg/String", "/note"), f"{MCAP} --topic /skin"),
    Misuse("a damaged message", log("std_msgs/msg/Float32MultiArray", "/skin"), MCAP),
]

INPUT = [
    Misuse("another unit", extra('[input]\nunit = "psi"\n'), WRONG),
    Misuse("another unit as an option", nothing, f"{GOOD} --unit psi"),
    Misuse("a misspelt key of input", extra("[input]\ntara = 1\n"), WRONG),
    Misuse("two tares", extra('[input]\ntare = "a.npy"\ntare_frames = 9\n'), WRONG),
    Misuse("two tares as options", nothing, f"{GOOD} --tare a.npy --tare-frames 9"),
    Misuse("a tare longer than the recording", nothing, f"{GOOD} --tare-frames 9"),
    Misuse("no file of the tare", nothing, f"{GOOD} --tare rest.npy"),
    Misuse("a tare of another sensor", array(np.zeros((3, 7))), f"{GOOD} --tare wrong.npy"),
    Misuse("a coding of pascals", nothing, f"{GOOD} --coding offset"),
    Misuse("pascals as codes", nothing, f"{GOOD} --unit codes"),
    Misuse(
        "offset binary as signed codes", recorded(lambda frames: np.rint(frames / LSB) + 8192), f"{NPY} --unit codes"
    ),
    Misuse(
        "signed codes as offset binary",
        recorded(lambda frames: np.rint(frames / LSB)),
        f"{NPY} --unit codes --coding offset",
    ),
    Misuse("columns that are rows", nothing, f"{GOOD} --order columns"),
    Misuse("an option without frames", nothing, "verify skin.toml --unit kPa"),
]

DOUBTS = [
    Misuse("pascals as kilopascals", recorded(lambda frames: frames), f"{NPY} --unit kPa", code=0),
    Misuse(
        "lines along rows, read along columns",
        recorded(lambda frames: frames.reshape(3, 30)),
        f"{NPY} --order columns", code=0,
    ),
    Misuse("the other sign", recorded(lambda frames: -frames), NPY, code=0),
    Misuse("a sign that was turned in vain", recorded(lambda frames: frames), f"{NPY} --compression positive", code=0),
    Misuse("kilopascals", recorded(lambda frames: frames / 1000), NPY, code=0),
    Misuse("codes as pascals", recorded(lambda frames: np.rint(frames / LSB)), NPY, code=0),
    Misuse("unipolar codes", recorded(lambda frames: np.rint(frames / LSB) + 8192), NPY, code=0),
    Misuse("no tare", recorded(lambda frames: frames + 5000), NPY, code=0),
    Misuse("a sensor at rest", recorded(noise), NPY, code=0),
    Misuse("saturation", recorded(lambda frames: np.maximum(9 * frames, -200e3)), NPY, code=0),
    Misuse("compression only", recorded(lambda frames: np.minimum(frames, 0)), NPY, code=0),
    Misuse("one frame again and again", recorded(lambda frames: frames[[0] * 20]), NPY, code=0),
    Misuse("offsets of single taxels", recorded(untared), NPY, code=0),
    Misuse("a stuck taxel", recorded(stuck), NPY, code=0),
    Misuse("over full scale", recorded(lambda frames: 100 * frames), f"{NPY} --engine fixed"),
]

RECORDINGS = LAYOUT + VALUES + HEADERS + TEXT + TABLES + INPUT + DOUBTS
