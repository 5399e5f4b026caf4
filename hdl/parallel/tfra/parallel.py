"""The parallel microarchitecture of TFRA."""

from tfra.hdl.parallel.core.microarchitecture import Parallel
from tfra.hdl.parallel.tfra.core import TfraCore
from tfra.hdl.parallel.tfra.timeline import TfraTimeline
from tfra.model.fixed.design import Design


class TfraParallel(Parallel[Design, TfraTimeline]):
    """The core of blocks that stream to each other."""

    core = TfraCore
    trace = TfraTimeline
