"""Equations as C source on the standard mathematics library alone: what the native FMU runs."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import sympy as sp
from sympy.printing.c import C99CodePrinter

from pipeclamp_models.base.kept import kept
from pipeclamp_models.equations import symbols
from pipeclamp_models.equations.replacing import replaced
from pipeclamp_models.law.compose import Composed
from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.bounded import bounded
from pipeclamp_models.realise.slopes import needed, slope_of, slopes_through
from pipeclamp_models.realise.stepping import Definition, Stepping, conditions_of, exact, parameter_symbols, stepping

EXACT_POWERS = range(2, 9)
"""Whole powers that are written as products, which is many times cheaper than `pow`."""
MOTION = "double y_previous, double y, double v, double h"


class CPrinter(C99CodePrinter):  # type: ignore[misc]
    """Print sign, steps and whole powers as C evaluates them best, and constants as numbers, for C99 names none."""

    def _print_NumberSymbol(self, expression: sp.Expr) -> str:
        return repr(float(expression))

    def _print_sign(self, expression: sp.Expr) -> str:
        argument = self._print(expression.args[0])
        return f"(double)((({argument}) > 0) - (({argument}) < 0))"

    def _print_Piecewise(self, expression: sp.Piecewise) -> str:
        *branches, (last, _) = expression.args
        text = self._print(last)
        for value, condition in reversed(branches):
            text = f"(({self._print(condition)}) ? ({self._print(value)}) : ({text}))"
        return str(text)

    def _print_Heaviside(self, expression: sp.Expr) -> str:
        return f"(double)(({self._print(expression.args[0])}) > 0)"

    def _print_Pow(self, expression: sp.Pow) -> str:
        base, exponent = expression.base, expression.exp
        if base.is_Atom and exponent.is_Integer and abs(int(exponent)) in EXACT_POWERS:
            product = "*".join([self._print(base)] * abs(int(exponent)))
            return f"({product})" if exponent > 0 else f"1.0/({product})"
        return str(super()._print_Pow(expression))


Block = tuple[Sequence[str], Sequence[sp.Expr]]
"""Targets of assignments and what they are assigned."""


@dataclass(frozen=True)
class Names:
    """A C array and the symbols that stand for its entries."""

    array: str
    symbols: tuple[sp.Symbol, ...]

    def locals(self) -> dict[sp.Symbol, sp.Symbol]:
        """Give the C names of the entries by their symbols."""
        return {symbol: _named(self.array, symbol, index) for index, symbol in enumerate(self.symbols)}

    def declarations(self, used: set[sp.Symbol]) -> list[str]:
        """Give the declarations of those entries that are used."""
        return [
            f"const double {name} = {self.array}[{index}];"
            for index, name in enumerate(self.locals().values())
            if name in used
        ]


def _named(kind: str, symbol: sp.Symbol, index: int = 0) -> sp.Symbol:
    """Give a C name: the symbol behind the name of its kind, so that no symbol meets a word of C."""
    name = str(symbol)
    return sp.Symbol(f"{kind}_{name if re.fullmatch(r'[A-Za-z0-9_]+', name) else index}", real=True)


def c_source(structure: Structure) -> str:
    """Give a law's structure as C functions, kept from one call to the next.

    Its parameters are arguments, so that no value is compiled in. It defines the counts `LAW_PARAMETERS`,
    `LAW_CONDITIONS`, `LAW_HELD`, `LAW_STATES`, the states before anything has moved, `law_rest`, and

    - `law_coefficients(p, u, k)`: from parameters p (`parameter_symbols`) and conditions u (`conditions_of`; mm, Hz, K)
      what holds through a step,
    - `law_step(k, z, y_previous, y, v, h, result, z_new)`: force (N) and stored energy (N mm) and the new states after
      a straight move from `y_previous` to `y` (mm) in `h` seconds,
    - `law_slopes(p, u, z, y_previous, y, v, h, slope)`: derivatives of that force, then of that energy, by y, v and
      each condition, memory included.
    """
    return str(kept(f"C {structure.equations_without_rig.key}", lambda: _c_source(structure)))


@bounded()
def _c_source(structure: Structure) -> str:
    law = stepping(structure)
    names = _names_of(law)
    counts = {"PARAMETERS": names.p, "CONDITIONS": names.u, "HELD": names.k, "STATES": names.z}
    rest = ", ".join(repr(float(state.start)) for state in law.equations.states) or "0.0"
    return "\n".join(
        [
            f"enum {{ {', '.join(f'LAW_{name} = {len(one.symbols)}' for name, one in counts.items())} }};",
            "",
            f"static const double law_rest[] = {{{rest}}};",
            "",
            *_coefficients(law, names),
            *_step(law, names),
            *_slopes(law, names),
        ]
    )


@dataclass(frozen=True)
class _LawNames:
    """The C names of parameters, conditions, coefficients, what holds through a step, and states before and after."""

    p: Names
    u: Names
    c: Names
    k: Names
    z: Names
    new: Names

    @property
    def of_conditions(self) -> dict[sp.Symbol, sp.Symbol]:
        """What coefficients are made of, and they."""
        return self.p.locals() | self.u.locals() | self.c.locals()


def _names_of(law: Stepping) -> _LawNames:
    equations = law.equations
    slow = {str(symbol): symbol for symbol in equations.slow_signals}
    return _LawNames(
        p=Names("p", parameter_symbols(equations)),
        u=Names("u", tuple(slow.get(name, sp.Symbol(name)) for name in conditions_of(equations))),
        c=Names("c", tuple(entry.symbol for entry in equations.coefficients)),
        k=Names("k", tuple(symbol for symbol, _ in law.held)),
        z=Names("z", tuple(state.symbol for state in equations.states)),
        new=Names("new", law.after),
    )


def _coefficients(law: Stepping, names: _LawNames) -> list[str]:
    """Give `law_coefficients`, see `c_source`."""
    of = names.of_conditions
    return _function(
        "static void law_coefficients(const double p[], const double u[], double k[])",
        (names.p, names.u),
        [
            _assigned(names.c, {symbol: replaced(value, of) for symbol, value in law.coefficients}),
            ([f"k[{index}]" for index in range(len(law.held))], [replaced(value, of) for _, value in law.held]),
        ],
        unused=("p", "u", "k"),
    )


def _step(law: Stepping, names: _LawNames) -> list[str]:
    """Give `law_step`, see `c_source`."""
    stages = Names("s", tuple(symbol for symbol, _ in law.stages))
    of = names.k.locals() | names.z.locals() | stages.locals() | names.new.locals()
    updates = zip(names.new.symbols, law.updates, strict=True)
    return _function(
        f"static void law_step(const double k[], const double z[], {MOTION}, double result[2], double z_new[])",
        (names.k, names.z),
        [
            *_one_by_one(law.stages, of),
            _assigned(names.new, {symbol: replaced(value, of) for symbol, value in updates}),
            ([f"z_new[{index}]" for index in range(len(law.after))], list(names.new.locals().values())),
            (["result[0]", "result[1]"], [replaced(value, of) for value in (law.force, law.energy)]),
        ],
        unused=("k", "z", "y_previous", "v", "h", "z_new"),
    )


def _slopes(law: Stepping, names: _LawNames) -> list[str]:
    """Give `law_slopes`, see `c_source`."""
    way, slopes = total_slopes(law.equations, (symbols.y, symbols.v, *names.u.symbols))
    used = set().union(*(slope.free_symbols for slope in (*slopes, *(value for _, value in way))))
    of_slopes = names.of_conditions | names.z.locals() | Names("s", tuple(symbol for symbol, _ in way)).locals()
    coefficients = {
        entry.symbol: replaced(exact(entry.expression), names.of_conditions)
        for entry in law.equations.coefficients
        if entry.symbol in used
    }
    return _function(
        "static void law_slopes(const double p[], const double u[], const double z[], "
        f"{MOTION}, double slope[{len(slopes)}])",
        (names.p, names.u, names.z),
        [
            _assigned(names.c, coefficients),
            *_one_by_one(way, of_slopes),
            ([f"slope[{index}]" for index in range(len(slopes))], [replaced(one, of_slopes) for one in slopes]),
        ],
        unused=("p", "u", "z", "y_previous", "y", "v", "h"),
    )


def _assigned(names: Names, expressions: Mapping[sp.Symbol, sp.Expr]) -> Block:
    """Give the definition of each entry as a name."""
    return (
        [f"const double {name}" for symbol, name in names.locals().items() if symbol in expressions],
        [expressions[symbol] for symbol in names.symbols if symbol in expressions],
    )


def _one_by_one(definitions: Iterable[Definition], names: Mapping[sp.Symbol, sp.Symbol]) -> list[Block]:
    """Give definitions as blocks of their own, for each may use those before it."""
    return [([f"const double {names[symbol]}"], [replaced(value, names)]) for symbol, value in definitions]


def total_slopes(equations: Composed, by: Iterable[sp.Symbol]) -> tuple[list[Definition], list[sp.Expr]]:
    """Give derivatives of the force and the energy after a step, through the states' update and the coefficients.

    Args:
        equations: the composed law.
        by: y, v and slow signals.

    Returns:
        what is computed before, in order, in fast signals, coefficients, parameters and states before the step; and the
        derivatives, first of the force, then of the energy, in these too.
    """
    signals = list(by)
    after = {state.symbol: sp.Symbol(f"_{state.symbol}", real=True) for state in equations.states}
    steps = [(stage.symbol, exact(stage.expression)) for stage in equations.stages]
    steps += [(after[state.symbol], exact(state.update)) for state in equations.states]
    results = [replaced(exact(expression), after) for expression in (equations.force, equations.energy)]
    coefficients = {entry.symbol: exact(entry.expression) for entry in equations.coefficients}
    way, through = slopes_through(steps, [*signals, *coefficients])

    def total(result: sp.Expr, signal: sp.Symbol) -> sp.Expr:
        own = slope_of(result, signal, through)
        inner = ((slope_of(result, symbol, through), value) for symbol, value in coefficients.items())
        return sum(
            (slope * sp.diff(value, signal) for slope, value in inner if slope is not None and value.has(signal)),
            own if own is not None else sp.Integer(0),
        )

    slopes = [total(result, signal) for result in results for signal in signals]
    return needed(way, slopes), slopes


def _function(
    head: str,
    arrays: Iterable[Names],
    blocks: Sequence[Block],
    unused: Sequence[str],
) -> list[str]:
    """Give a C function: the entries that it uses, then blocks of assignments, common parts computed once.

    Args:
        head: return type, name and arguments.
        arrays: the arrays that symbols are entries of.
        blocks: targets and their expressions; a block may use the targets of those before it.
        unused: arguments that a law may leave unused, named so that a compiler doesn't warn of them.
    """
    printer = CPrinter({"math_macros": {}})
    names = sp.numbered_symbols("part_", real=True)
    used: set[sp.Symbol] = set()
    body: list[str] = []
    for targets, expressions in blocks:
        parts, reduced = sp.cse(list(expressions), symbols=names)
        body += [f"const double {symbol} = {printer.doprint(expression)};" for symbol, expression in parts]
        body += [f"{target} = {printer.doprint(part)};" for target, part in zip(targets, reduced, strict=True)]
        used = used.union(*(expression.free_symbols for expression in expressions))
    declared = [line for array in arrays for line in array.declarations(used)]
    text = "\n".join((*declared, *body))
    silent = [f"(void){name};" for name in unused if not re.search(rf"\b{name}\b", text)]
    return [head, "{", *(f"    {line}" for line in (*declared, *silent, *body)), "}", ""]
