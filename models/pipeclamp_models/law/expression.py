"""Expressions of users as mathematics: a restricted grammar, parsed into SymPy and never run.

Numbers, names (of letters of all scripts, in their NFKC form), + - * / **, brackets, and the functions of `FUNCTIONS`;
`where(a < b, p, q)` is p where a < b, else q.
Numbers are worked out at once as floats, so that nothing an expression holds can grow beyond them.
"""

from __future__ import annotations

import ast
import math
import operator
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

import sympy as sp

from pipeclamp_models.base.errors import UserError, did_you_mean

MOST_CHARACTERS = 2000
"""Characters of an expression, at most."""
MOST_LEVELS = 100
"""Levels of brackets, functions and operators inside one another, at most."""
HIGHEST_POWER = 100
"""Largest exponent that is a number."""
LARGEST_NUMBER = 1e100
"""Largest number that an expression may hold, and the inverse of the smallest."""
MOST_ARGUMENTS = 8

Value: TypeAlias = "sp.Expr | float"
"""What a part of an expression stands for: a number while it is one."""


@dataclass(frozen=True)
class Function:
    """A function of the grammar: on numbers, on mathematics, and how many arguments it takes."""

    of_numbers: Callable[..., float]
    of_expressions: Callable[..., sp.Expr]
    arguments: range = range(1, 2)


def _compared(quantity: sp.Expr) -> sp.Expr:
    """Give what is compared; a choice inside a comparison makes SymPy unfold all its ways, which takes for ever.

    Raises:
        NotImplementedError: there is one.
    """
    if quantity.has(sp.Piecewise):
        raise NotImplementedError(f"holds a choice ({WHERE}, or the abs or sign of a logarithm) within a comparison")
    return quantity


def _absolute(quantity: sp.Expr) -> sp.Expr:
    """|q|, with a derivative also where SymPy can't tell that q is real."""
    if quantity.is_extended_real:
        return sp.Abs(quantity)
    return sp.Piecewise((quantity, _compared(quantity) >= 0), (-quantity, True))


def _sign(quantity: sp.Expr) -> sp.Expr:
    """Sgn q, zero at zero; see `_absolute`."""
    if quantity.is_extended_real:
        return sp.sign(quantity)
    return sp.Piecewise((1, _compared(quantity) > 0), (-1, quantity < 0), (0, True))


SEVERAL = range(2, MOST_ARGUMENTS + 1)
FUNCTIONS: Mapping[str, Function] = {
    "abs": Function(abs, _absolute),
    "sign": Function(lambda number: float((number > 0) - (number < 0)), _sign),
    "min": Function(min, sp.Min, SEVERAL),
    "max": Function(max, sp.Max, SEVERAL),
    "exp": Function(math.exp, sp.exp),
    "log": Function(math.log, sp.log),
    "sqrt": Function(math.sqrt, sp.sqrt),
    "sin": Function(math.sin, sp.sin),
    "cos": Function(math.cos, sp.cos),
    "tanh": Function(math.tanh, sp.tanh),
}
WHERE = "where"
CONSTANTS: Mapping[str, float] = {"pi": math.pi}

OPERATORS: Mapping[type[ast.AST], Callable[[Value, Value], Value]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
COMPARISONS: Mapping[type[ast.AST], tuple[Callable[[float, float], bool], Callable[[sp.Expr, sp.Expr], sp.Basic]]] = {
    ast.Lt: (operator.lt, sp.Lt),
    ast.LtE: (operator.le, sp.Le),
    ast.Gt: (operator.gt, sp.Gt),
    ast.GtE: (operator.ge, sp.Ge),
}
NO_VALUE = (ArithmeticError, TypeError, ValueError, RecursionError)
"""What arithmetic and SymPy raise where there is no real value."""


def parse_expression(text: str, names: Mapping[str, sp.Expr], where: str) -> sp.Expr:
    """Read an expression.

    Args:
        text: the expression.
        names: what each name that it may use stands for.
        where: what the expression is, for messages.

    Raises:
        UserError: it isn't of the grammar, uses another name, or has no real value; with the character where.
    """
    return as_expression(_Reader(text, names, where).read())


def as_expression(value: Value) -> sp.Expr:
    """Give a number as SymPy sees it without loss; whole numbers stay whole, so that factors of 1 vanish."""
    if isinstance(value, sp.Expr):
        return value
    number = float(value)
    return sp.Integer(int(number)) if number == int(number) and abs(number) < 2**53 else sp.Float(number)


def has_value(expression: sp.Expr, symbol: sp.Symbol, value: float) -> bool:
    """Whether an expression has a real value where a symbol takes one, whatever the others are."""
    try:
        there = expression.subs(symbol, as_expression(value)) if symbol in expression.free_symbols else expression
        return not there.has(sp.zoo, sp.oo, -sp.oo, sp.nan, sp.I)
    except NO_VALUE:
        return False


@dataclass(frozen=True)
class _Reader:
    """Reads one expression."""

    text: str
    names: Mapping[str, sp.Expr]
    where: str

    def read(self) -> Value:
        text = self.text
        if not text.strip():
            raise self._error(None, "is empty; expected an expression such as c * v")
        if len(text) > MOST_CHARACTERS:
            raise self._error(None, f"has {len(text)} characters; expected {MOST_CHARACTERS} at most")
        for place, character in enumerate(text):
            if not (_is_ascii_text(character) or character.isalpha()) or character in "#\\;":
                raise self._error(place, f"{character!r} is no character of an expression")
        # A text of several lines is one expression.
        line = "".join(" " if character.isspace() else character for character in text)
        indent = len(line) - len(line.lstrip())
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                tree = ast.parse(line.strip(), mode="eval")
        except SyntaxError as error:
            raise self._error(indent + max((error.offset or 1) - 1, 0), f"is no expression: {error.msg}") from error
        except (ValueError, RecursionError, MemoryError) as error:
            raise self._error(None, "is no expression that can be read") from error
        encoded = line.strip().encode()
        for node in ast.walk(tree.body):
            if hasattr(node, "col_offset"):  # in bytes
                node.col_offset = indent + len(encoded[: node.col_offset].decode())
        return self._value(tree.body, MOST_LEVELS)

    def _value(self, node: ast.expr, depth: int) -> Value:
        """Give what a part of the expression stands for."""
        if depth == 0:
            raise self._error(node.col_offset, f"is nested too deep; expected {MOST_LEVELS} levels at most")
        match node:
            case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
                return self._sound(node, lambda: float(number))
            case ast.Name(id=name):
                return self._named(node, name)
            case ast.UnaryOp(op=ast.USub() | ast.UAdd() as sign, operand=operand):
                value = self._value(operand, depth - 1)
                return -value if isinstance(sign, ast.USub) else value
            case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATORS:
                return self._operation(node, op, self._value(left, depth - 1), self._value(right, depth - 1))
            case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
                return self._call(node, name, arguments, depth)
            case ast.BinOp(op=ast.BitXor()):
                raise self._error(node.col_offset, "^ is no operator here; expected ** for a power")
            case ast.Compare():
                raise self._error(node.col_offset, f"a comparison stands only first in {WHERE}(comparison, a, b)")
        raise self._error(
            node.col_offset,
            f"{type(node).__name__} is not of the grammar; expected numbers, names, + - * / **, brackets and the "
            f"functions {', '.join((*FUNCTIONS, WHERE))}",
        )

    def _named(self, node: ast.expr, name: str) -> Value:
        if name in self.names:
            return self.names[name]
        if name in CONSTANTS:
            return CONSTANTS[name]
        if name in (*FUNCTIONS, WHERE):
            raise self._error(node.col_offset, f"{name} is a function; expected {name}(...)")
        raise self._error(node.col_offset, f"name {_unknown(name, (*self.names, *CONSTANTS))}")

    def _operation(self, node: ast.expr, op: ast.operator, left: Value, right: Value) -> Value:
        if isinstance(op, ast.Pow) and not isinstance(right, sp.Expr) and abs(right) > HIGHEST_POWER:
            raise self._error(node.col_offset, f"exponent {right:g}; expected {HIGHEST_POWER} at most")
        if not (isinstance(left, sp.Expr) or isinstance(right, sp.Expr)):
            return self._sound(node, lambda: OPERATORS[type(op)](left, right))
        if isinstance(op, ast.Div) and right == 0.0:
            raise self._error(node.col_offset, "divides by zero")
        return self._sound(node, lambda: OPERATORS[type(op)](as_expression(left), as_expression(right)))

    def _call(self, node: ast.Call, name: str, arguments: list[ast.expr], depth: int) -> Value:
        if name == WHERE:
            return self._choice(node, arguments, depth)
        function = FUNCTIONS.get(name)
        if function is None:
            raise self._error(node.col_offset, f"function {_unknown(name, (*FUNCTIONS, WHERE))}")
        values = [self._value(argument, depth - 1) for argument in arguments]
        if len(values) not in function.arguments:
            expected = "1" if function.arguments == range(1, 2) else f"{SEVERAL[0]} to {SEVERAL[-1]}"
            raise self._error(node.col_offset, f"{name} has {len(values)} arguments; expected {expected}")
        if not any(isinstance(value, sp.Expr) for value in values):
            return self._sound(node, lambda: function.of_numbers(*values))
        return self._sound(node, lambda: function.of_expressions(*map(as_expression, values)))

    def _choice(self, node: ast.Call, arguments: list[ast.expr], depth: int) -> Value:
        match arguments:
            case [ast.Compare(left=left, ops=[op], comparators=[right]), first, second] if type(op) in COMPARISONS:
                pass
            case _:
                raise self._error(
                    node.col_offset,
                    f"{WHERE} got {len(arguments)} arguments; expected {WHERE}(comparison, a, b) with one of "
                    "< <= > >= in the comparison",
                )
        sides = self._value(left, depth - 1), self._value(right, depth - 1)
        branches = self._value(first, depth - 1), self._value(second, depth - 1)
        of_numbers, of_expressions = COMPARISONS[type(op)]
        if not any(isinstance(side, sp.Expr) for side in sides):
            return branches[0] if of_numbers(*sides) else branches[1]
        one, other = map(as_expression, branches)

        def choice() -> Value:
            return sp.Piecewise(
                (one, of_expressions(*(_compared(as_expression(side)) for side in sides))), (other, True)
            )

        return self._sound(node, choice)

    def _sound(self, node: ast.expr, make: Callable[[], Value]) -> Value:
        """Give a value that is real, with numbers of a sane size; what has become a number is one."""
        try:
            value = make()
            numbers = value.atoms(sp.Number) if isinstance(value, sp.Expr) else (value,)
            sane = all(number == 0 or 1 / LARGEST_NUMBER < abs(float(number)) < LARGEST_NUMBER for number in numbers)
        except NotImplementedError as error:
            raise self._error(node.col_offset, str(error)) from error
        except NO_VALUE as error:
            raise self._error(node.col_offset, "has no real value, or one too large") from error
        if not sane or (isinstance(value, sp.Expr) and value.has(sp.I, sp.zoo, sp.oo, sp.nan)):
            raise self._error(
                node.col_offset,
                f"has no real value, or a number above {LARGEST_NUMBER:g} or below {1 / LARGEST_NUMBER:g}",
            )
        return float(value) if isinstance(value, sp.Number) else value

    def _error(self, place: int | None, reason: str) -> UserError:
        shown = self.text if len(self.text) <= 80 else f"{self.text[:77]}..."
        at = "" if place is None else f", character {place + 1}"
        return UserError(f"{self.where}{at}: {reason} (got {shown!r})")


def _is_ascii_text(character: str) -> bool:
    return character.isascii() and (character.isprintable() or character.isspace())


def _unknown(name: str, known: tuple[str, ...]) -> str:
    return f"{name[:40]!r} is not known here; {did_you_mean(name, known, most=3)}expected one of {', '.join(known)}"
