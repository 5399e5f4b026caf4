"""The parallel microarchitecture of the learned estimator."""

from tfra.hdl.parallel.core.microarchitecture import Parallel
from tfra.hdl.parallel.learned.core import LearnedCore
from tfra.hdl.parallel.learned.timeline import LearnedTimeline
from tfra.model.fixed.learned.design import LearnedDesign


class LearnedParallel(Parallel[LearnedDesign, LearnedTimeline]):
    """The core of blocks that stream to each other."""

    core = LearnedCore
    trace = LearnedTimeline
