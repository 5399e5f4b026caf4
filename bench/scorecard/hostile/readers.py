"""Every reader of bytes from outside, with valid inputs to begin with: what is drawn, and what reads it."""

import os
import socket
import struct
import sys
from contextlib import suppress
from importlib import import_module
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from bench.publish import ROOT
from bench.scorecard.hostile import kept, logs
from bench.scorecard.hostile.mutate import changed_bytes, of
from bench.scorecard.hostile.reader import (
    CONFIG,
    Prepared,
    Reader,
    configured,
    of_file,
)
from tfra.calibrate.loads import read_loads
from tfra.codegen.config.read import load
from tfra.codegen.package.drivers import driver_files
from tfra.codegen.sidecar.build import sidecar
from tfra.hdl.ip.framer import FORMAT, FORMAT_PLACE, RECORDS_FORMAT
from tfra.model.skin.records import results
from tfra.model.skin.scenes import recorded
from tfra.recordings.calibration import File, read_calibration, written
from tfra.recordings.input import Input
from tfra.runtime.errors import InputError
from tfra.runtime.store import cached
from tfra.study.search.trials import StoreError
from tfra.study.studyfile import load_study
from tfra.view.feed import Feed
from tfra.view.server import _Handler

STUDIES = ("study_hertz", "study_learned_quick", "study_quick", "study_skin")


def config(folder: Path) -> Prepared:
    """CONFIG files: the examples, of which two have weights."""
    for name in ("hertz_40x20.weights.npz", "skin_8x12.weights.npz"):
        (folder / name).write_bytes((ROOT / "examples" / name).read_bytes())
    seeds = [file.read_bytes() for file in sorted((ROOT / "examples").glob("*.toml")) if "study" not in file.name]
    return of([*seeds, CONFIG.encode()]), of_file(folder / "fuzzed.toml", load)


def study(folder: Path) -> Prepared:
    """STUDY files of a small CONFIG, of which one takes a skin."""
    (folder / "skin.toml").write_text(CONFIG + "[window]\nrows = 3\ncolumns = 3\n")
    configured(folder)
    for name in ("hertz_40x20", "learned_fast", "skin_8x12"):
        (folder / f"{name}.toml").write_text(CONFIG)
    seeds = [(ROOT / "examples" / f"{name}.toml").read_bytes().replace(b"to = 3.0", b"to = 1.0") for name in STUDIES]
    return of(seeds), of_file(folder / "study.toml", load_study)


def calibration(folder: Path) -> Prepared:
    """Files of ``tfra calibrate``."""
    sensor, table = configured(folder).design.sensor, np.arange(1.0, 13).reshape(3, 4).tolist()
    cover = {"thickness_mm": 3.0, "thickness_error_mm": 0.1, "poisson": 0.48, "poisson_error": 0.01}
    form = {"form": "tfra-calibration-1", "order": "rows", "flip_x": False, "compression": "negative"}
    tables = {"gain": table, "gain_error": table, "rest": table, "noise": table, "dead": [[0, 1]]}
    seeds = [written(File.model_validate({**form, **tables, "cover": cover})).encode()]
    given = Input()
    return of(seeds), of_file(folder / "cal.toml", lambda file: read_calibration(file, sensor, given))


def loads(folder: Path) -> Prepared:
    """Tables of loads."""
    names = "recording,force_n,tangential_n,direction_deg,indenter,radius_mm,x_mm,y_mm,frames,branch,error_percent\n"
    seeds = [
        names + 'ball,5,1,30,ball,4,6,4.5,120-180,loading,1\n"flat, one",3,,,flat,2,,,,unloading,\n',
        "recording;force_n;tilt_deg\n# steps\na;5,5;30\nb;2;0\n",
        "recording\tpressure_kpa\nair\t30\nrest\t\n",
    ]
    return of([seed.encode() for seed in seeds]), of_file(folder / "loads.csv", read_loads)


def request(folder: Path) -> Prepared:
    """Requests to the server of ``tfra live``."""
    feed = Feed("source", lambda stress: {}, 1)
    feed.read([], lambda fault: None)
    feed.tare = SimpleNamespace(told="Tare.", again=lambda: None)
    server: Any = SimpleNamespace(feed=feed, page=b"page", server_port=80, over=False)
    heads = ("GET / HTTP/1.1", "GET /frames?after=3 HTTP/1.1", "GET /drawn?count=5 HTTP/1.1", "POST /tare HTTP/1.1")
    rest = "\r\nHost: 127.0.0.1:80\r\nOrigin: http://127.0.0.1:80\r\nConnection: close\r\n\r\n"

    def read(data: bytes) -> None:
        ours, theirs = socket.socketpair()
        with ours, theirs:
            theirs.sendall(data[:60_000])
            theirs.shutdown(socket.SHUT_WR)
            with suppress(OSError):
                _Handler(ours, ("127.0.0.1", 9), server)

    return of([(head + rest).encode() for head in heads]), read


def output_frames(folder: Path) -> Prepared:
    """Output frames of a core and of a skin, in the driver of Python."""
    array: Any = configured(folder)
    skin = configured(folder, CONFIG + "[window]\nrows = 3\ncolumns = 3\n").skin
    for name, content in driver_files(skin).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(content)
    sys.path.insert(0, str(folder / "python"))
    host = import_module("tfra_host")
    alone, both = sidecar(array.design), sidecar(skin)
    codes = np.random.default_rng(1).integers(-3000, 3000, (4, 3, 4))
    seeds = [beats(words, FORMAT) for words in array.design.model(codes).words]
    seeds += [beats(words, RECORDS_FORMAT) for words in results(skin, recorded(skin))]

    def read(data: bytes) -> None:
        taken = host.read_contacts(both, BytesIO(data))
        refused = []
        for parse, facts, given in (
            (host.parse_frame, alone, data),
            (host.parse_contacts, both, data),
            (host.parse_contacts, both, taken),
        ):
            try:
                parse(facts, given)
            except host.DeviceError as error:
                refused.append(error)
        if len(refused) == 3:
            raise InputError("frame", "", str(refused[0]))

    return of(seeds, changed_bytes), read


def beats(words: Any, form: int) -> bytes:
    """An output frame of result words, of one or more records."""
    numbers = [0, form << FORMAT_PLACE, *(word & 0xFFFFFFFF for word in np.ravel(words).tolist())]
    return struct.pack(f"<{len(numbers)}I", *numbers)


def environment(folder: Path) -> Prepared:
    """The variable that limits the cache."""

    def read(data: bytes) -> None:
        os.environ["TFRA_CACHE_MB"] = data.replace(b"\0", b"").decode(errors="surrogateescape")
        cached(folder / "fem-0123456789abcdef", lambda: {"a": b""})

    return of([b"500", b"1"]), read


READERS = {
    "CONFIG": Reader(config, 60_000),
    "STUDY": Reader(study, 10_000),
    "calibration": Reader(calibration, 60_000),
    "loads": Reader(loads, 100_000),
    "text": Reader(logs.text, 60_000),
    "lines of a stream": Reader(logs.stream, 10_000),
    ".npy": Reader(logs.npy, 50_000),
    ".npz": Reader(logs.npz, 40_000),
    "Parquet": Reader(logs.tables, 10_000),
    "MCAP": Reader(logs.mcap, 10_000),
    "rosbag2": Reader(logs.bag, 10_000),
    "references": Reader(kept.references, 30_000),
    "results": Reader(kept.results_of_arrays, 10_000),
    "results of skins": Reader(kept.results_of_skins, 10_000),
    "weights": Reader(kept.weights, 20_000),
    "cache": Reader(kept.entry, 40_000),
    "work folders": Reader(kept.work, 40_000),
    "trials": Reader(kept.trials, 10_000, (InputError, StoreError)),
    "manifests": Reader(kept.manifest, 60_000),
    "seals": Reader(kept.seal, 110_000),
    "requests": Reader(request, 150_000),
    "frames of a core": Reader(output_frames, 150_000),
    "environment": Reader(environment, 20_000),
}
