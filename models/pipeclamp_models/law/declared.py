"""A user's own effect: a declaration made into an effect with the same rights as those of the catalogue."""

from __future__ import annotations

import keyword
import re
import unicodedata
from functools import lru_cache

import sympy as sp

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.time_limit import time_limit
from pipeclamp_models.equations import symbols
from pipeclamp_models.equations.effect import NOTHING, Coefficient, Effect, Parameter, State
from pipeclamp_models.law.catalogue import identifiers
from pipeclamp_models.law.declaration import Declaration, ParameterTable
from pipeclamp_models.law.expression import has_value, parse_expression
from pipeclamp_models.law.names import FIXED, RESERVED, SCALES, SLOW, Signals

PLACES = (symbols.y, symbols.x, symbols.y_previous)
"""What counts from `about_mm` in expressions."""
MOST_SECONDS_DECLARING = 30
"""That SymPy may take for a declaration; one of a person's size takes less than a second."""


@lru_cache(maxsize=1024)
def effect_of(declaration: Declaration) -> Effect:
    """Make the effect that a declaration states.

    Forces, energies and factors may use what varies within a cycle (y, x, v, y_previous, h; a for rig effects), slow
    signals (A, f, T, N, rho, conditions), parameters, coefficients and states; updates the same but x; coefficients
    slow signals and parameters; a path y, slow signals and parameters; a lag parameters. With `about_mm` y, x and
    y_previous count from there, mm.

    Raises:
        UserError: the id is one of the catalogue's, or an expression can't serve; the message names the place.
    """
    if declaration.id in identifiers():
        raise UserError(f"id {declaration.id!r} is an effect of the catalogue; expected an id of its own")
    too_long = UserError(
        f"effect {declaration.id!r}: its expressions take more than {MOST_SECONDS_DECLARING} s; expected simpler ones: "
        "fewer min, max, abs, where and powers within one another"
    )
    with time_limit(MOST_SECONDS_DECLARING, too_long):
        return _Maker(declaration).effect()


class _Maker:
    """Makes one effect, names first, then what is said in them."""

    def __init__(self, declaration: Declaration) -> None:
        self.declaration = declaration
        fast = [signal.symbol for signal in symbols.FAST if signal.symbol is not symbols.a or declaration.part == "rig"]
        self.fast: Signals = {str(symbol): symbol for symbol in fast}
        if declaration.about_mm:
            self.fast = {**self.fast, **{str(one): one - declaration.about_mm for one in PLACES}}
        further = self._conditions()
        self.slow: Signals = {**SLOW, **further}
        tables = (declaration.parameters, declaration.coefficients, declaration.states)
        own = [[table.symbol for table in group] for group in tables]
        names = [*further, *(name for group in own for name in group)]
        for name in names:
            if names.count(name) > 1:
                raise self._error(f"the name {name!r} is used twice; expected different names")
        self.parameters, self.coefficients, self.states = (
            {name: sp.Symbol(name, real=True) for name in group} for group in own
        )

    def effect(self) -> Effect:
        declaration, slow = self.declaration, {**self.slow, **self.parameters, **FIXED}
        anything = {**self.fast, **slow, **self.coefficients, **self.states}
        update = {name: symbol for name, symbol in anything.items() if name != str(symbols.x)}
        states = tuple(
            State(
                self.states[table.symbol],
                table.unit,
                table.meaning,
                self._expression(table.update, update, f"states, update of {table.symbol}"),
                table.start,
            )
            for table in declaration.states
        )
        coefficients = tuple(
            Coefficient(
                self.coefficients[table.symbol],
                table.unit,
                table.role,
                self._expression(table.expression, slow, f"coefficients, {table.symbol}"),
            )
            for table in declaration.coefficients
        )
        factors = {name: symbol for name, symbol in anything.items() if name not in self.coefficients}
        scales: dict[str, sp.Expr] = {}
        for table in declaration.scales:
            if table.coefficient in scales:
                raise self._error(f"scales: {table.coefficient!r} is there twice; expected one factor for each")
            scales[table.coefficient] = self._expression(
                table.factor, factors, f"scales, factor of {table.coefficient}"
            )
        path = {str(symbols.y): symbols.y, **slow}
        effect = Effect(
            id=declaration.id,
            part=declaration.part,
            does=declaration.title,
            source=declaration.source or f"declared by a user: {declaration.title}",
            looks_like=declaration.looks_like,
            imitated_by=declaration.imitated_by,
            told_apart_by=declaration.told_apart_by or "not stated in the declaration",
            parameters=tuple(self._parameter(table) for table in declaration.parameters),
            coefficients=coefficients,
            force=self._optional(declaration.force, anything, "force"),
            states=states,
            energy=self._optional(declaration.energy, anything, "energy"),
            scales=scales,
            replaces={symbols.x: self._expression(declaration.path, path, "path")} if declaration.path else {},
            lag=self._optional(declaration.lag, self.parameters, "lag"),
        )
        self._check(effect)
        return effect

    def _conditions(self) -> Signals:
        """Give the further columns of runs.csv that the effect uses, by the names they have in expressions."""
        found: dict[str, sp.Expr] = {}
        for column in self.declaration.conditions:
            name = unicodedata.normalize("NFKC", re.sub(r"\W", "_", column))  # as names in expressions are read
            if not name.isidentifier() or keyword.iskeyword(name) or name in RESERVED:
                raise self._error(f"conditions: {column!r} can't stand in an expression; rename the column")
            found[name] = symbols.condition_symbol(column)
        return found

    def _parameter(self, table: ParameterTable) -> Parameter:
        place = f"parameters, {table.symbol}"

        def quantity(value: float | str | None, what: str, otherwise: float) -> sp.Expr | float:
            if value is None:
                return otherwise
            if isinstance(value, float):
                return value
            return self._expression(value, SCALES, f"{place}, {what}")

        starts = tuple(quantity(value, "start", 0.0) for value in table.start)
        for name in table.follows:
            if name not in self.slow:
                raise self._error(f"{place}, follows: got {name!r}; expected one of {', '.join(self.slow)}")
        if table.follows and table.neutral is None:
            raise self._error(f"{place}: follows {', '.join(table.follows)} but has no neutral value to be frozen at")
        parameter = Parameter(
            self.parameters[table.symbol],
            table.unit,
            table.meaning,
            starts if len(starts) > 1 else starts[0],
            lower=quantity(table.lower, "lower", float("-inf")),
            upper=quantity(table.upper, "upper", float("inf")),
            neutral=table.neutral,
            follows=tuple(self.slow[name] for name in table.follows),
            levels=table.levels,
        )
        within = [*(("start", start) for start in starts), ("neutral", table.neutral)]
        for what, value in within:
            stated = [one for one in (parameter.lower, value, parameter.upper) if isinstance(one, float)]
            if stated != sorted(stated) or parameter.lower == parameter.upper:
                raise self._error(f"{place}: got {stated} as lower, {what}, upper; expected rising numbers")
        return parameter

    def _check(self, effect: Effect) -> None:
        """Refuse an effect that does nothing, holds something that nothing uses, or asks for what isn't there."""
        declaration = self.declaration
        doing = [effect.force, *effect.scales.values(), *effect.replaces.values(), effect.lag]
        if not any(expression != 0 for expression in doing):
            raise self._error("it does nothing; expected a force, scales, a path or a lag")
        if declaration.path and declaration.about_mm:
            raise self._error("about_mm: a path stands in place of x, which counts from 0; expected one of the two")
        if effect.lag != 0 and effect.part != "rig":
            raise self._error('lag: only what the rig adds is late; expected part = "rig"')
        used = set().union(
            *(expression.free_symbols for expression in doing),
            *(coefficient.expression.free_symbols for coefficient in effect.coefficients),
            *(state.update.free_symbols for state in effect.states),
        )
        for name, symbol in {**self.parameters, **self.coefficients, **self.states}.items():
            if symbol not in used:
                raise self._error(f"{name!r} is declared but no force, factor, update or path uses it; leave it out")
        self._check_values(effect)
        counts = {len(table.start) for table in declaration.parameters} - {1}
        if len(counts) > 1:
            raise self._error("parameters: expected one start, or equally many of each parameter")

    def _check_values(self, effect: Effect) -> None:
        """Refuse an effect that has no value where one of its parameters is neutral or begins."""
        parts = {
            "force": effect.force, "energy": effect.energy, "lag": effect.lag,
            **{f"factor of {name}": factor for name, factor in effect.scales.items()},
            **{f"path of {signal}": path for signal, path in effect.replaces.items()},
            **{f"coefficient {one.symbol}": one.expression for one in effect.coefficients},
            **{f"update of {state.symbol}": state.update for state in effect.states},
        }  # fmt: skip
        for parameter in effect.parameters:
            for what, value in (("neutral", parameter.neutral), *(("start", start) for start in parameter.starts)):
                if not isinstance(value, float):
                    continue
                for part, expression in parts.items():
                    if not has_value(expression, parameter.symbol, value):
                        raise self._error(
                            f"parameters, {parameter.name}, {what}: got {value:g}, where the {part} has no value; "
                            "expected one at which all expressions have values, or expressions that do"
                        )

    def _optional(self, text: str, names: Signals, place: str) -> sp.Expr:
        return self._expression(text, names, place) if text else NOTHING

    def _expression(self, text: str, names: Signals, place: str) -> sp.Expr:
        return parse_expression(text, names, f"effect {self.declaration.id!r}, {place}")

    def _error(self, reason: str) -> UserError:
        return UserError(f"effect {self.declaration.id!r}: {reason}")
