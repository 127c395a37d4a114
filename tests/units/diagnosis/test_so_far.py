"""What is told of a ladder while it is climbed, and which law stays."""

from types import SimpleNamespace

from pipeclamp_identification.workflow.climb import Rung
from pipeclamp_identification.workflow.so_far import SoFar
from pipeclamp_models.law.step import BeforeAfter, LawStep


def rung(effect, before, after):
    return Rung(SimpleNamespace(step=LawStep((effect,)), heldout=BeforeAfter(before, after)), "part", ())


def test_each_rung_is_told_once_and_the_best_law_is_kept():
    kept, said = [], []
    so_far = SoFar(lambda what: None, kept.append, said.append)
    memory, delay, play = rung("memory", 0.10, 0.05), rung("delay", 0.05, 0.04), rung("play", 0.10, 0.06)
    assert so_far.steps == ""
    so_far.come("memory", (memory,))
    so_far.come("memory, delay", (memory, delay))
    assert so_far.steps == "+ memory + delay"
    so_far.come("play", (play,))
    assert kept == ["memory", "memory, delay"]
    assert so_far.best == "memory, delay"
    assert so_far.words() == "10.00% -> 4.00% on left-out conditions"
    assert [line.partition(" s: ")[2] for line in said] == [
        "rung 1: + memory (part): error on left-out conditions 10.00% -> 5.00%",
        "rung 2: + delay (part): error on left-out conditions 5.00% -> 4.00%",
        "another way, rung 1: + play (part): error on left-out conditions 10.00% -> 6.00%",
    ]
