"""A skin's records: the header of every contact, then the words of its window."""

from typing import Any

from amaranth import Array, Const, Mux, Signal, Value

from bench.formal.bench import Bench
from bench.formal.prove import Proof
from bench.formal.streams import RULE, SOON, Scoreboard, stays, taken
from tfra.hdl.skin.records import Records
from tfra.model.fixed.tfra.design import TfraDesign
