"""HLS cores in C simulation: the words of the bit-accurate model, faults that are noticed, the schedule as stated."""

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.codegen.c.cases import SMALL, frames
from tests.codegen.hls.csim import built, headers, said
from tests.codegen.package.made import write
from tests.marks import long
from tfra.codegen.config.read import load
from tfra.codegen.hls.files import data, files
from tfra.model.fixed.design import Design

CASES = ["3x5", *long(*(case for case in SMALL if case != "3x5"))]
MORE = ["fast", "hertz_40x20", "skin_8x12", "learned_fast", "learned_resultant"]


def simulated(design: Design, folder: Path, count: int) -> None:
    """``count`` frames or more have the model's words."""
    codes = frames(design, count)
    codes = codes.reshape(len(codes), -1)
    words = design.model(codes).words
    texts = files(design) | {
        "tb_data/tb_input_features.dat": data(codes),
        "tb_data/tb_output_predictions.dat": data(words),
    }
    assert (
        said(built(folder, texts, design.name))
        == f"{design.name}: {len(codes)} frames, {words.size} words, all right\n"
    )
    np.testing.assert_array_equal(np.loadtxt(folder / "tb_data/csim_results.log", dtype=np.int64), words)


@pytest.mark.parametrize("case", CASES)
def test_words(case: str, tmp_path: Path) -> None:
    simulated(SMALL[case], tmp_path, 2000)


@pytest.mark.long
@pytest.mark.parametrize("name", MORE)
def test_words_of_examples(name: str, tmp_path: Path) -> None:
    simulated(load(f"examples/{name}.toml").design, tmp_path, 2000)


def test_projects_are_for_a_zynq_at_100_mhz() -> None:
    texts = files(SMALL["3x5"])
    assert {"part=xc7z020clg400-1", "clock=10ns"} <= set(texts["hls_config.cfg"].split())
    assert "part xc7z020clg400-1 period 10}" in texts["build_prj.tcl"]


@pytest.mark.parametrize("case", long("3x5", "learned_4x6"))
def test_recorded_frames_notice_a_wrong_table(case: str, tmp_path: Path) -> None:
    design = SMALL[case]
    texts = files(design)
    assert said(built(tmp_path, texts, design.name)).endswith("all right\n")
    table = f"firmware/weights/{next(iter(design.stacks.values())).operators[0].name.upper()}.h"
    start = texts[table].index("= {")
    wrong = re.sub(r"-?\d{3,}", lambda found: str(int(found[0]) ^ 64), texts[table][start:], count=1)
    texts[table] = texts[table][:start] + wrong
    assert re.match(r"frame \d+, word \d+, \w+: -?\d+, -?\d+ is right\n", said(built(tmp_path, texts, design.name), 1))


@pytest.mark.long
def test_its_readme(tmp_path: Path) -> None:
    """Its command for g++ is right but for the place of the headers, which it loads; every file is told of."""
    design = SMALL["learned_4x6"]
    texts = files(design)
    write(tmp_path, texts)
    (command,) = re.findall(r"^    (g\+\+ .*)$", texts["README.md"], re.M)
    assert "hls4ml/hls4ml/templates/vivado/ap_types" in command
    command = command.replace("hls4ml/hls4ml/templates/vivado/ap_types", str(headers()))
    subprocess.run(command.split(), cwd=tmp_path, check=True, capture_output=True)
    assert said(tmp_path / "csim").endswith("all right\n")
    told = re.findall(r"`([\w./]+)`", texts["README.md"])
    assert [name for name in texts if not any(name.startswith(one) for one in told)] == ["README.md"]


FAULTS = """
#include "firmware/NAME.h"
#include <cstdio>
#include <initializer_list>

static void send(hls::stream<beat_t> &codes, int count, int last)
{
    for (int t = 0; t < count; t++) {
        beat_t beat;
        beat.data = t % 3 - 1;
        beat.last = t == last;
        codes.write(beat);
    }
}

int main()
{
    hls::stream<beat_t> codes, words;
    ap_uint<32> misplaced;
    send(codes, TAXELS, TAXELS - 1);     // whole
    send(codes, 4, 3);                   // ends early
    send(codes, TAXELS + 2, TAXELS + 1); // ends late: a frame without an end, and one of 2 codes
    send(codes, TAXELS, TAXELS - 1);     // whole
    for (int frame = 0; frame < 5; frame++) {
        NAME(codes, words, misplaced);
        std::printf("%u:", (unsigned)misplaced);
        for (bool last = false; !last;) {
            const beat_t beat = words.read();
            std::printf(" %lld", (long long)beat.data.to_int64());
            last = beat.last;
        }
        std::printf("\\n");
    }
    return codes.empty() && words.empty() ? 0 : 1;
}
"""


@pytest.mark.long
def test_frames_of_a_wrong_length_are_counted_and_the_next_is_right(tmp_path: Path) -> None:
    design = SMALL["learned_4x6"]
    taxels = design.sensor.taxels
    test = FAULTS.replace("NAME", design.name).replace("TAXELS", str(taxels))
    lines = said(built(tmp_path, files(design) | {"faults.cpp": test}, design.name, "faults.cpp")).splitlines()
    assert [int(line.partition(":")[0]) for line in lines] == [0, 1, 2, 3, 3]
    sent = np.arange(taxels) % 3 - 1
    codes = [np.where(np.arange(taxels) < end, sent, 0) for end in (taxels, 4, taxels)]
    codes += [np.where(np.arange(taxels) < 2, np.roll(sent, -taxels), 0), sent]
    codes[3][:2] = [taxels % 3 - 1, (taxels + 1) % 3 - 1]
    words = np.array([list(map(int, line.partition(":")[2].split())) for line in lines])
    np.testing.assert_array_equal(words, design.model(np.array(codes)).words)


@pytest.mark.parametrize("case", long("learned_3x5", "2x2", "5x4", "learned_4x6"))
def test_the_schedule_counts_what_the_pipelines_do(case: str, tmp_path: Path) -> None:
    """Every iteration of a pipeline adds its interval: no frame has more than the README's latency, and one has it."""
    design = SMALL[case]
    texts = files(design)
    for name in texts:
        if name.startswith("firmware/"):
            texts[name] = re.sub(r"#pragma HLS PIPELINE II=(\w+)", r"counted += \1;", texts[name])
    texts["firmware/defines.h"] = "extern long counted;\n" + texts["firmware/defines.h"]
    test, call = f"{design.name}_test.cpp", f"{design.name}(codes, words, misplaced);"
    most = f'counted = 0; {call} most = counted > most ? counted : most; std::printf("%ld cycles\\n", most);'
    texts[test] = texts[test].replace(call, most).replace("int main()", "long counted = 0, most = 0;\nint main()")
    printed = re.findall(r"(\d+) cycles", said(built(tmp_path, texts, design.name)))
    readme = texts["README.md"].replace(",", "")
    stages = [int(n) for n in re.findall(r"^\| `\w+` \| (\d+) \|$", readme, re.M)]
    assert re.findall(r"every \*\*(\d+)\*\* cycles and its last word after \*\*(\d+)\*\*", readme) == [
        (str(max(stages)), printed[-1])
    ]
    assert sum(stages) == int(printed[-1])
