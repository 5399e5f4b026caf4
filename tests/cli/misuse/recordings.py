"""Cases of misuse of recordings: wrong layouts, values, files and readings of them."""

from __future__ import annotations

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
    Misuse("rows and columns exchanged", array(np.zeros((3, COLUMNS, ROWS))), NPY, "is every frame transposed?"),
    Misuse("a transposed frame", array(np.zeros((COLUMNS, ROWS))), NPY, "is every frame transposed? (--order columns)"),
    Misuse("times in an array", array(np.zeros((3, 31))), NPY, "is the first column a time stamp? (--skip-columns 1)"),
    Misuse("frames along the last axis", array(np.zeros((ROWS, COLUMNS, 3))), NPY, "are frames along the last axis?"),
    Misuse("no frame", array(np.zeros((0, ROWS, COLUMNS))), NPY, "at least one frame is needed, got none"),
    Misuse("another sensor's frames", array(np.zeros((3, 4, 4))), NPY, "shape (n, 5, 6) or (n, 30) is needed, got"),
]

VALUES = [
    Misuse("NaN", array(np.full((1, ROWS, COLUMNS), np.nan)), NPY, "frame 0, row 0, column 0 is not finite"),
    Misuse("beyond any stress", array(np.full((1, ROWS, COLUMNS), 1e160)), NPY, "is 1e+160 Pa, the limit is"),
    Misuse("unsigned wrap", array(np.full((1, 5, 6), 2**64 - 1, np.uint64)), NPY, "is 1.84467e+19 Pa, the limit"),
    Misuse("complex stress", array(np.zeros((1, ROWS, COLUMNS)) * 1j), NPY, "real numbers are needed, got complex128"),
    Misuse(
        "complex reference",
        references(mu_ref=np.ones(3) * 1j),
        "verify skin.toml --frames wrong.npz",
        "mu_ref: real numbers are needed, got complex128",
    ),
    Misuse(
        "infinite reference",
        references(mu_ref=[0, 1, np.inf]),
        "verify skin.toml --frames wrong.npz",
        "mu_ref: frame 2: inf is no true value",
    ),
    Misuse(
        "reference of text",
        references(phi_ref_deg=list("abc")),
        "verify skin.toml --frames wrong.npz",
        "phi_ref_deg: real numbers are needed, got <U1",
    ),
]

HEADERS = [
    Misuse("a shape of booleans", header("(True, 5, 6)"), NPY, "the header is damaged"),
    Misuse("a shape beyond 2^64", header(f"({2**64}, 5, 6)"), NPY, "the impossible shape (18446744073709551616, 5, 6)"),
    Misuse(
        "a shape beyond the file",
        header("(1000000000000, 5, 6)"),
        NPY,
        "promises 240,000,000,000,000 bytes of numbers, the file has 240",
    ),
    Misuse("Python objects", header("(1, 5, 6)", "'|O'"), NPY, "real numbers are needed, got object"),
    Misuse("an unknown version", header("(1, 5, 6)", version=9), NPY, "version 1, 2 or 3 of the .npy format is needed"),
    Misuse("a damaged LZMA member", member(garble, zipfile.ZIP_LZMA), NPZ, "frames: is damaged"),
    Misuse("a damaged deflate member", member(garble, zipfile.ZIP_DEFLATED), NPZ, "frames: is damaged"),
    Misuse("a wrong checksum", member(put(14, 7)), NPZ, "frames: is damaged: Bad CRC-32"),
    Misuse("an encrypted member", member(put(6, 1)), NPZ, "frames: is encrypted"),
    Misuse("an unknown compression", member(put(8, 99)), NPZ, "frames: cannot be unpacked"),
    Misuse("no key frames", lambda: np.savez("wrong.npz", stress=1), NPZ, "the key is missing, the file has: stress"),
    Misuse("a mistaken suffix", raw("wrong.npy", b"PK\3\4" + bytes(99)), NPY, "is not a .npy array: it is a .npz file"),
]

TEXT = [
    Misuse("decimal commas", lines(",", point=","), CSV, "decimal commas? then numbers need another separator"),
    Misuse(
        "points and commas",
        lines(";", first="1,5" + ";1" * 29 + "\n"),
        CSV,
        "line 2: this line has decimal points, others have decimal commas",
    ),
    Misuse("a column of times", lines(before="0.{},"), CSV, "is the first column a time stamp? (--skip-columns 1)"),
    Misuse("times of the clock", lines("\t", before="12:30:0{}\t"), CSV, "a time stamp? (--skip-columns 1)"),
    Misuse("times and numbers", lines(";", before="0.{0};{0};"), CSV, "first 2 columns no taxels? (--skip-columns 2)"),
    Misuse("nothing to skip", lines(), f"{CSV} --skip-columns 1", "are all columns taxels? (--skip-columns 0)"),
    Misuse("numbered headings", lines(first=",".join(map(str, range(30))) + "\n"), CSV, "from 0 to 29 are headings"),
    Misuse("a typo in the first line", lines(first="1.x" + ",1" * 29 + "\n"), CSV, "line 1: '1.x' at position 1"),
    Misuse("a digit of another script", lines(first="\u0661" + ",1" * 29 + "\n"), CSV, "at position 1 is not a number"),
    Misuse("an underscore", lines(first="1_000" + ",1" * 29 + "\n"), CSV, "'1_000' at position 1 is not a number"),
    Misuse("UTF-16", raw("wrong.csv", "1,2\n".encode("utf-16")), CSV, "is UTF-16 text, UTF-8 is needed"),
    Misuse("a megabyte in a cell", lines(first="y" * 1_000_000 + ",1" * 29 + "\n"), CSV, "(1,000,002 characters)"),
    Misuse("an empty file", raw("wrong.csv", b""), CSV, "at least one frame is needed, got none"),
]

TABLES = [
    Misuse("text called Parquet", raw("wrong.parquet", b"1,2,3\n"), PARQUET, "is not a Parquet file, or ends early"),
    Misuse("text in Parquet", table({"note": ["a"]}), PARQUET, "column 'note': lists of real numbers are needed"),
    Misuse("a gap in Parquet", table({"skin": [[1.0] * 29 + [None]]}), PARQUET, "'skin': lacks a value, first at 29"),
    Misuse("all columns skipped", table({"skin": [[1.0] * 30]}), f"{PARQUET} --skip-columns 1", "1 of 1 columns"),
    Misuse("text called MCAP", raw("wrong.mcap", b"1,2,3\n" * 9), MCAP, "is not a readable log"),
    Misuse("a log without frames", log("std_msgs/msg/String", "/note"), MCAP, "its topics: /note"),
    Misuse("no such topic", log("std_msgs/msg/String", "/note"), f"{MCAP} --topic /skin", "no topic '/skin'"),
    Misuse("a damaged message", log("std_msgs/msg/Float32MultiArray", "/skin"), MCAP, "message of '/skin' is damaged"),
]

INPUT = [
    Misuse("another unit", extra('[input]\nunit = "psi"\n'), WRONG, "input.unit: 'Pa', 'kPa' or 'codes' is needed"),
    Misuse("another unit as an option", nothing, f"{GOOD} --unit psi", "'psi' is not one of 'Pa', 'kPa', 'codes'"),
    Misuse("a misspelt key of input", extra("[input]\ntara = 1\n"), WRONG, 'the nearest valid key is "tare"'),
    Misuse("two tares", extra('[input]\ntare = "a.npy"\ntare_frames = 9\n'), WRONG, "input.tare: give the tare as"),
    Misuse("two tares as options", nothing, f"{GOOD} --tare a.npy --tare-frames 9", "--tare: give the tare as"),
    Misuse("a tare longer than the recording", nothing, f"{GOOD} --tare-frames 9", "the first 9 frames are the tare"),
    Misuse("no file of the tare", nothing, f"{GOOD} --tare rest.npy", "rest.npy: cannot be read: No such file"),
    Misuse("a tare of another sensor", array(np.zeros((3, 7))), f"{GOOD} --tare wrong.npy", "wrong.npy: frames: shape"),
    Misuse("a coding of pascals", nothing, f"{GOOD} --coding offset", "--coding: only codes have a coding"),
    Misuse("pascals as codes", nothing, f"{GOOD} --unit codes", "is the unit Pa or kPa? (--unit)"),
    Misuse(
        "offset binary as signed codes",
        recorded(lambda frames: np.rint(frames / LSB) + 8192),
        f"{NPY} --unit codes",
        "are they offset binary? (--coding offset)",
    ),
    Misuse(
        "signed codes as offset binary",
        recorded(lambda frames: np.rint(frames / LSB)),
        f"{NPY} --unit codes --coding offset",
        "are they signed? (--coding signed)",
    ),
    Misuse("columns that are rows", nothing, f"{GOOD} --order columns", "is every frame transposed? (--order rows)"),
    Misuse("an option without frames", nothing, "verify skin.toml --unit kPa", "--unit: is for recordings only"),
]

DOUBTS = [
    Misuse(
        "pascals as kilopascals",
        recorded(lambda frames: frames),
        f"{NPY} --unit kPa",
        "is the file in kPa, and adc.full_scale_pa in Pa (not in kPa)? (--unit Pa)",
        0,
    ),
    Misuse(
        "lines along rows, read along columns",
        recorded(lambda frames: frames.reshape(3, 30)),
        f"{NPY} --order columns",
        "are rows and columns swapped? (--order rows)",
        0,
    ),
    Misuse("the other sign", recorded(lambda frames: -frames), NPY, "is compression positive in this file?", 0),
    Misuse(
        "a sign that was turned in vain",
        recorded(lambda frames: frames),
        f"{NPY} --compression positive",
        "is compression negative in this file?",
        0,
    ),
    Misuse("kilopascals", recorded(lambda frames: frames / 1000), NPY, "was nothing pressed? (--unit kPa)", 0),
    Misuse("codes as pascals", recorded(lambda frames: np.rint(frames / LSB)), NPY, "Pa)? (--unit codes)", 0),
    Misuse("unipolar codes", recorded(lambda frames: np.rint(frames / LSB) + 8192), NPY, "--coding offset)", 0),
    Misuse("no tare", recorded(lambda frames: frames + 5000), NPY, "was the sensor tared (--tare-frames N", 0),
    Misuse("a sensor at rest", recorded(noise), NPY, "40 of 40 frames have no contact: was the sensor at rest?", 0),
    Misuse("saturation", recorded(lambda frames: np.maximum(9 * frames, -200e3)), NPY, "was it saturated", 0),
    Misuse("compression only", recorded(lambda frames: np.minimum(frames, 0)), NPY, "does this array measure compr", 0),
    Misuse("one frame again and again", recorded(lambda frames: frames[[0] * 20]), NPY, "is the recording stuck?", 0),
    Misuse("offsets of single taxels", recorded(untared), NPY, "was the sensor tared", 0),
    Misuse("a stuck taxel", recorded(stuck), NPY, "(row, column) (2, 3): is it stuck?", 0),
    Misuse(
        "over full scale",
        recorded(lambda frames: 100 * frames),
        f"{NPY} --engine fixed",
        "over the full scale of 200000 Pa",
    ),
]

RECORDINGS = LAYOUT + VALUES + HEADERS + TEXT + TABLES + INPUT + DOUBTS
