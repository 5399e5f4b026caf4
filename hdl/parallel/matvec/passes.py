"""Cycles of the passes of the matrix-vector unit, from the choice of a product to its results."""

from tfra.hdl.parallel.matvec.drain import drain_latency, drain_steps
from tfra.hdl.parallel.matvec.images import passes
from tfra.hdl.parallel.matvec.operand import MEASURE, PREPARE
from tfra.hdl.parallel.matvec.plan import Plan
from tfra.hdl.parallel.matvec.schedule import spacing
from tfra.model.fixed.design import Design

FULL = MEASURE + 1
"""Cycles from the last operand quad's transfer to the choice that finds it."""
_CHOICE = 1
"""Cycles from there to the launch."""
CAPTURE = PREPARE + 7
"""Cycles from a quad's read to sums that hold its products."""
_NEXT_CHOICE = 2
"""Cycles from a product's last launch to the next choice: the launch frees the buffer, and the choice sees that."""

_NEVER = 1 << 62


def full(design: Design, plan: Plan, stack: str) -> int:
    """:data:`FULL` for the operand of ``stack``; one that is flowing is found by its first quad."""
    return 2 - design.stacks[stack].operand_quads if plan.source(stack).flowing(design) else FULL


class Passes:
    """The passes so far; ``next_choice`` is the first cycle in which another product may be chosen."""

    def __init__(self, design: Design) -> None:
        self._design = design
        self._next_launch = self.next_choice = -_NEVER
        self._drained = [-_NEVER, -_NEVER]
        """Of the last two passes, the cycle in which their last words leave the drain register."""

    def product(self, stack: str, cycle: int) -> tuple[list[int], list[int]]:
        """Launches of the passes of a product that is chosen in ``cycle``, and when its result quads leave the unit."""
        design = self._design
        launches = [self._launch(stack, cycle + _CHOICE) for _ in range(passes(design, stack))]
        self.next_choice = launches[-1] + _NEXT_CHOICE
        results = []
        for quad in range(design.stacks[stack].quads):
            turn, row = divmod(4 * quad + 3, design.architecture.mac_lanes)
            leave = row // design.architecture.vector_words + drain_latency(design)
            results.append(self._captured(stack, launches[turn]) + leave)
        return launches, results

    def _captured(self, stack: str, launch: int) -> int:
        """Cycle in which the sums of a pass are captured."""
        return launch + self._design.stacks[stack].operand_quads + CAPTURE

    def _launch(self, stack: str, ready: int) -> int:
        """Launch the next pass, not before cycle ``ready``.

        It waits for the pass before, and for the one before that to have left the drain register.
        """
        launch = max(ready, self._next_launch, self._drained[-2] + 1)
        self._next_launch = launch + spacing(self._design, stack)
        self._drained = [self._drained[-1], self._captured(stack, launch) + drain_steps(self._design)]
        return launch
