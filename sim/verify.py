"""Verify a core: every word of every frame against the bit-accurate model, its timing, and the float reference."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from rich.console import Console
from rich.table import Table

from tfra.hdl.cores import regular, timing
from tfra.model.design import Design
from tfra.model.fixed.numbers import Ints
from tfra.model.fixed.pipeline import FixedResult, FixedTfra
from tfra.model.fixed.words import decode, frame_words, layout, quantise
from tfra.model.metrics import error_force, error_mu, error_phi
from tfra.model.scenes import wild_codes
from tfra.model.sensor import Floats
from tfra.model.tfra import Result, Status, Tfra
from tfra.sim import tools
from tfra.sim.run import Netlist, Progress, ProtocolError, Run, SimulationError, simulate
from tfra.sim.stimuli import Stimuli, mixture

PATTERNS = ("none", "random", "bursts")
"""Stalls on both ports; each pattern gets every third frame."""

LAST_STAGE = "scaling"
"""Where words go wrong that no probe saw."""


@dataclass(frozen=True)
class Mismatch:
    """The first word that differs.  ``taxel`` is (row, column) for a force; ``stall`` the pattern of the run."""

    frame: int
    stall: str
    field: str
    taxel: tuple[int, int] | None
    word: int
    expected: int
    observed: int
    stage: str | None = None
    """First stage, in the order of the data, whose transfers differ; None if no probes were to be had."""
    transfer: int | None = None
    """The stage's first transfer that differs."""

    def __str__(self) -> str:
        taxel = "" if self.taxel is None else f", taxel {self.taxel}"
        stage = "" if self.stage is None else f", stage {self.stage}"
        stage += "" if self.transfer is None else f" (transfer {self.transfer})"
        return (
            f"frame {self.frame} (stalls: {self.stall}), field {self.field}{taxel}, word {self.word}{stage}: "
            f"{self.expected} expected, {self.observed} observed"
        )


@dataclass(frozen=True)
class Timing:
    """Cycles, measured without stalls, and as the design states them; None where not known."""

    latency: int | None
    interval: int | None
    design_latency: int | None
    design_interval: int | None

    @property
    def agrees(self) -> bool:
        """No measured number differs from a stated one."""
        pairs = ((self.latency, self.design_latency), (self.interval, self.design_interval))
        return all(a is None or b is None or a == b for a, b in pairs)


@dataclass(frozen=True)
class FloatErrors:
    """The core against float TFRA on the same codes, in percent of Eqs. 33-35: the largest errors.

    Frames without contact, with compression only, or with words that were limited, are left out.
    """

    frames: int
    equal_index: float
    """Share of equal sweep indices, 0 ... 1."""
    index_distance: int
    phi: float
    mu: float
    force: float


@dataclass(frozen=True)
class ContactErrors:
    """Median and largest error against the contacts' true values, in percent (Eqs. 33-35).

    Frames with a status are left out; they have no direction, no friction, or values beyond the words.
    """

    frames: int
    force: tuple[float, float]
    mu: tuple[float, float]
    phi: tuple[float, float]


@dataclass(frozen=True)
class Report:
    """What a verification found."""

    name: str
    simulator: str
    seed: int
    kinds: dict[str, int]
    words: int
    """Words that should have been compared."""
    compared: int
    mismatches: int
    first: Mismatch | None
    violations: tuple[str, ...]
    timing: Timing
    status: dict[str, int]
    against_float: dict[str, FloatErrors]
    against_contact: ContactErrors | None

    @property
    def frames(self) -> int:
        """Frames simulated."""
        return sum(self.kinds.values())

    @property
    def passed(self) -> bool:
        """Every word was compared and equal, the streams kept their rules, and the timing is as stated."""
        complete = self.compared == self.words > 0
        return complete and not self.mismatches and not self.violations and self.timing.agrees

    def as_dict(self) -> dict[str, Any]:
        """Return everything as plain JSON types."""
        content = _plain(asdict(self))
        timing = content["timing"] | {"agrees": self.timing.agrees}
        return {"passed": self.passed, "frames": self.frames, **content, "timing": timing}

    def render(self, console: Console) -> None:
        """Print the report."""
        for table in (self._summary(), self._float_table()):
            if table.row_count:
                console.print(table)
        if self.first:
            console.print(f"first mismatch: {self.first}", style="red", highlight=False)
        for violation in self.violations:
            console.print(f"stream rule broken: {violation}", style="red", highlight=False)
        verdict = "every bit equals the model" if self.passed else "FAILED"
        console.print(f"{self.name}: {verdict}", style="green" if self.passed else "bold red", highlight=False)

    def _summary(self) -> Table:
        table = Table(title=f"{self.name} on {self.simulator}, seed {self.seed}", show_header=False)
        frames = ", ".join(f"{count} {kind}" for kind, count in self.kinds.items())
        table.add_row("frames", f"{self.frames} ({frames})")
        table.add_row("words compared", f"{self.compared} of {self.words}")
        table.add_row("mismatches", str(self.mismatches))
        t = self.timing
        table.add_row("latency / cycles", _against(t.latency, t.design_latency))
        table.add_row("interval / cycles", _against(t.interval, t.design_interval))
        table.add_row("status", ", ".join(f"{name} {count}" for name, count in self.status.items()))
        if self.against_contact:
            e = self.against_contact
            pairs = {"force": e.force, "mu": e.mu, "phi": e.phi}
            text = ", ".join(f"{name} {median:.2f} / {most:.2f} %" for name, (median, most) in pairs.items())
            table.add_row("against the contacts", f"median / largest error of {e.frames} frames: {text}")
        return table

    def _float_table(self) -> Table:
        columns = ("frames", "number", "equal index", "index distance", "phi / %", "mu / %", "force / %")
        table = Table(*columns, title="Against float TFRA on the same codes, largest errors")
        for kind, e in self.against_float.items():
            numbers = f"{e.frames}", f"{100 * e.equal_index:.1f} %", f"{e.index_distance}"
            table.add_row(kind, *numbers, f"{e.phi:.3f}", f"{e.mu:.3f}", f"{e.force:.3f}")
        return table


def verify(
    design: Design,
    frames: npt.ArrayLike | None = None,
    simulator: str | None = None,
    seed: int = 0,
    random: int = 200,
    references: Mapping[str, npt.ArrayLike] | None = None,
    progress: Progress | None = None,
    *,
    core: Netlist | Any = None,
) -> Report:
    """Simulate the core of ``design`` and compare every result word with the bit-accurate model.

    Args:
        frames: Stresses ``(n, rows, columns)`` in Pa; without any (None or n = 0), simulated contacts and directed
            frames are made up.
        simulator: As for :func:`tfra.sim.run.simulate`.
        seed: Of made-up frames and of stalls.
        random: Random frames to add.
        references: What is known of ``frames``, by the keys of a frames file (``REFERENCES``).
        progress: Called with numbers of finished frames.
        core: Another core to verify, as for ``simulate``.

    Raises ``InputError`` for an unusable simulator, ``ValueError`` for frames of a wrong shape or over full scale, and
    ``SimulationError`` when the simulation can't be carried out.  What the core does wrong is in the report.
    """
    chosen = tools.choose(simulator)
    stimuli = _stimuli(design, frames, seed, random, references)
    thirds = [_Third(design, stimuli, number, chosen, seed, core, progress) for number in range(len(PATTERNS))]
    thirds = [third for third in thirds if third.frames]
    bad = next((third for third in thirds if third.first is not None), None)
    result, seen = _joined(design, stimuli, thirds)
    return Report(
        name=design.name,
        simulator=chosen,
        seed=seed,
        kinds={str(kind): int((stimuli.kinds == kind).sum()) for kind in dict.fromkeys(stimuli.kinds)},
        words=len(stimuli.codes) * frame_words(design),
        compared=sum(third.compared for third in thirds),
        mismatches=sum(third.mismatches for third in thirds),
        first=bad.located() if bad else None,
        violations=tuple(f"stalls {third.pattern}: {note}" for third in thirds for note in third.violations),
        timing=_timing(design, thirds[0], core),
        status=_histogram(result),
        against_float=_float_errors(design, seen, result),
        against_contact=_contact_errors(seen, result),
    )


def _stimuli(
    design: Design,
    frames: npt.ArrayLike | None,
    seed: int,
    random: int,
    references: Mapping[str, npt.ArrayLike] | None,
) -> Stimuli:
    given = np.empty(0) if frames is None else np.asarray(frames, dtype=np.float64)
    if not given.size:
        return mixture(design, seed, random)
    known = Stimuli.of(quantise(design, given), "given", references)
    return known + Stimuli.of(wild_codes(design, random, seed), "random")


class _Third:
    """Every third frame, with one pattern of stalls."""

    def __init__(
        self,
        design: Design,
        stimuli: Stimuli,
        number: int,
        simulator: str,
        seed: int,
        core: Any,
        progress: Progress | None,
    ) -> None:
        self.pattern, self.number = PATTERNS[number], number
        self.part = slice(number, None, len(PATTERNS))
        self._codes, self._model = stimuli.codes[self.part], FixedTfra(design)
        self._design, self._simulator, self._seed, self._core = design, simulator, seed, core
        self.frames = len(self._codes)
        self.run: Run | None = None
        self.violations: list[str] = []
        self.words: Ints = np.empty((0, frame_words(design)), dtype=np.int64)
        self.compared = self.mismatches = 0
        self.first: tuple[int, int] | None = None
        if self.frames:
            self._simulate(progress)

    def _simulate(self, progress: Progress | None) -> None:
        expected = self._model(self._codes).words
        try:
            self.run = self._again(self._codes, expected, progress=progress)
        except ProtocolError as error:
            self.violations = error.violations
            self.compared, self.mismatches = error.compared, error.mismatches
            return
        self.words = self.run.words
        different = self.words != expected
        self.compared, self.mismatches = self.run.compared, int(different.sum())
        if self.run.mismatches != self.mismatches:
            raise SimulationError(
                f"the testbench counted {self.run.mismatches} mismatches, there are {self.mismatches}"
            )
        if self.mismatches:
            frame, word = np.argwhere(different)[0].tolist()
            self.first = frame, word

    def _again(
        self,
        codes: Ints,
        expected: Ints,
        simulator: str | None = None,
        probes: bool = False,
        progress: Progress | None = None,
    ) -> Run:
        chosen = simulator or self._simulator
        return simulate(
            self._design,
            codes,
            chosen,
            self._seed + self.number,
            self.pattern,
            self.pattern,
            progress=progress,
            expected=expected,
            core=self._core if chosen == "amaranth" or isinstance(self._core, Netlist) else None,
            probes=probes,
        )

    def alone(self) -> int:
        """Latency of the first frame in an idle core: frames behind it would delay it."""
        run = self._again(self._codes[:1], self._model(self._codes[:1]).words)
        return int(run.latency[0])

    def located(self) -> Mismatch:
        """Return the first mismatch with everything that a second run with probes can tell."""
        assert self.first is not None
        frame, word = self.first
        expected, observed = int(self._model(self._codes).words[frame, word]), int(self.words[frame, word])
        field = next(f for f in layout(self._design) if f.start <= word < f.start + f.count)
        taxel = None
        if field.name == "forces":
            place = (word - field.start) % self._design.sensor.taxels
            taxel = divmod(place, self._design.sensor.columns)
        stage, transfer = self._stage(frame)
        original = self.number + frame * len(PATTERNS)
        name = f"forces.{'xyz'[(word - field.start) // self._design.sensor.taxels]}" if taxel else field.name
        return Mismatch(original, self.pattern, name, taxel, word, expected, observed, stage, transfer)

    def _stage(self, frame: int) -> tuple[str | None, int | None]:
        """Rerun the frame with probes, alone or, if that goes well, behind the ones before it."""
        simulator = self._probing()
        if simulator is None:
            return None, None
        for start in (frame, 0):
            codes = self._codes[start : frame + 1]
            model = self._model(codes)
            try:
                run = self._again(codes, model.words, simulator, probes=True)
            except (ProtocolError, SimulationError):
                return None, None
            if run.mismatches:
                return first_difference(run, model, frame - start)
        return None, None

    def _probing(self) -> str | None:
        """Return a simulator that can watch probes; Amaranth's own does not know the Verilog's names.

        Gates have no probes: synthesis keeps no signal between blocks by its name.
        """
        if isinstance(self._core, Netlist) and not self._core.probes:
            return None
        if self._simulator != "amaranth":
            return self._simulator
        other = tools.choose()
        return other if other != "amaranth" and self._core is None else None


def first_difference(run: Run, model: FixedResult, frame: int) -> tuple[str | None, int | None]:
    """Return the first stage, in the order of the data, whose transfers of ``frame`` differ, and the first of them."""
    if not run.probes:
        return None, None
    for stage, found in run.probes.items():
        expected = model.stages[stage][frame]
        words = expected.reshape(-1)
        if frame >= len(found) or found.shape[1] != words.size:
            return stage, None
        different = np.flatnonzero(found[frame] != words)
        if len(different):
            per_transfer = expected.shape[-1] if expected.ndim > 1 else words.size
            return stage, int(different[0]) // per_transfer
    return LAST_STAGE, None


def _joined(design: Design, stimuli: Stimuli, thirds: list[_Third]) -> tuple[Result, Stimuli]:
    """Results of all frames that came back, and the frames they belong to."""
    back = [third for third in thirds if len(third.words) == third.frames]
    words = np.concatenate([third.words for third in back] or [np.empty((0, frame_words(design)), dtype=np.int64)])
    seen = stimuli[:0]
    for third in back:
        seen = seen + stimuli[third.part]
    return decode(design, words), seen


def _timing(design: Design, third: _Third, core: Any) -> Timing:
    """Latency of a frame that is alone, and the interval over the frames that the design's statement is about."""
    latency = interval = None
    window, enough = regular(design)
    if third.run is not None:
        latency = third.alone()
        interval = math.ceil(third.run.interval[window].mean()) if len(third.run.words) >= enough else None
    return Timing(latency, interval, *_stated(design, core))


def _stated(design: Design, core: Any) -> tuple[int | None, int | None]:
    if core is None:
        stated = timing(design)
        return stated.latency, stated.initiation_interval
    facts = core.sidecar if isinstance(core, Netlist) else {}
    return facts.get("latency_cycles"), facts.get("interval_cycles")


def _histogram(result: Result) -> dict[str, int]:
    counts = {"none": int((result.status == 0).sum())}
    return counts | {str(flag.name): int((result.status & flag != 0).sum()) for flag in Status}


def _float_errors(design: Design, seen: Stimuli, result: Result) -> dict[str, FloatErrors]:
    exact = Tfra.of(design)(seen.codes * design.adc.lsb)
    special = Status.NO_CONTACT | Status.COMPRESSION_ONLY | Status.OUTPUT_SATURATED
    regular = (result.status & special) == 0
    found = {}
    for kind in dict.fromkeys(seen.kinds.tolist()):
        pick = regular & (seen.kinds == kind)
        if pick.any():
            distance = np.abs(exact.sweep_index - result.sweep_index)[pick]
            found[kind] = FloatErrors(
                frames=int(pick.sum()),
                equal_index=float((distance == 0).mean()),
                index_distance=int(distance.max()),
                phi=float(error_phi(exact.phi_deg, result.phi_deg)[pick].max()),
                mu=float(error_mu(exact.mu, result.mu)[pick].max()),
                force=float(error_force(exact.resultant, result.resultant)[pick].max()),
            )
    return found


def _contact_errors(seen: Stimuli, result: Result) -> ContactErrors | None:
    known = np.isfinite(seen.resultant).all(axis=1) & (result.status == 0)
    if not known.any():
        return None
    errors: list[Floats] = [
        error_force(seen.resultant, result.resultant)[known].max(axis=1),
        error_mu(seen.mu, result.mu)[known],
        error_phi(seen.phi_deg, result.phi_deg)[known],
    ]
    return ContactErrors(int(known.sum()), *((float(np.median(e)), float(e.max())) for e in errors))


def _against(measured: int | None, stated: int | None) -> str:
    shown = ["not measured" if measured is None else str(measured)]
    if stated is not None:
        shown.append(f"design: {stated}")
    return ", ".join(shown)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
