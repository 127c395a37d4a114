"""What stands in series with a whole clamp: the path behind it moves otherwise, and another force comes through."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import sympy as sp

from pipeclamp_models.equations import symbols
from pipeclamp_models.equations.effect import Effect, Stage, State
from pipeclamp_models.equations.replacing import replaced


@dataclass(frozen=True)
class Path:
    """Forces that act on one displacement, composed.

    Attributes:
        force: N, in fast signals and states after the step.
        energy: stored, N mm, likewise.
        states: their memory.
        stages: what is computed on the way to the states after a step, in order.
    """

    force: sp.Expr
    energy: sp.Expr
    states: tuple[State, ...]
    stages: tuple[Stage, ...]


def behind(effect: Effect, path: Path) -> Path:
    """Put a path behind an effect that replaces its displacement.

    Args:
        effect: replaces `y`, and `v` where it has to.
        path: what stands behind it, as if nothing stood before it.
    """
    stood = replaced(effect.replaces[symbols.y], {symbols.y: symbols.y_previous})
    stages: list[Stage] = []

    def moved_to(place: sp.Expr, velocity: sp.Expr, rounded: sp.Expr) -> sp.Symbol:
        """Give the path's force after a move to a place, which becomes a stage, with those that it takes itself."""
        end = f"_{len(stages)}_"
        there = {symbols.y: place, symbols.y_previous: stood, symbols.v: velocity, symbols.v_r: rounded}
        copies = {stage.symbol: sp.Symbol(f"{stage.symbol}{end}", real=True) for stage in path.stages}
        stages.extend(_moved(path.stages, {**copies, **there}))
        after = replaced(replaced(path.force, {state.symbol: state.update for state in path.states}), copies | there)
        found = sp.Symbol(f"{symbols.F_moved}{end}", real=True)
        stages.append(Stage(found, "N", "force of all behind it at a place", after))
        return found

    for stage in effect.stages:
        expression = stage.expression.replace(symbols.F_moved, moved_to)
        stages.append(replace(stage, expression=expression))
    own = {state.symbol: sp.Symbol(f"{state.symbol}_after_", real=True) for state in effect.states}
    stages += [Stage(own[state.symbol], state.unit, state.meaning, state.update) for state in effect.states]
    moved = {signal: effect.replaces.get(signal, signal) for signal in (symbols.y, symbols.v)}
    in_step = {signal: replaced(place, own) for signal, place in moved.items()} | {symbols.y_previous: stood}
    return Path(
        force=replaced(effect.passes, {symbols.F_path: replaced(path.force, moved)}),
        energy=replaced(path.energy, moved),
        states=(
            *(replace(state, update=own[state.symbol]) for state in effect.states),
            *(replace(state, update=replaced(state.update, in_step)) for state in path.states),
        ),
        stages=(*stages, *_moved(path.stages, in_step)),
    )


def _moved(stages: tuple[Stage, ...], by: Mapping[sp.Symbol, sp.Expr]) -> list[Stage]:
    """Give stages in other symbols, their own among them where these are replaced."""
    return [
        replace(stage, symbol=by.get(stage.symbol, stage.symbol), expression=replaced(stage.expression, by))
        for stage in stages
    ]
