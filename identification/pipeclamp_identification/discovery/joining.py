"""Two terms that add a force as one: in proportion to one strength, so that one declaration holds them."""

from __future__ import annotations

import re

from pipeclamp_identification.discovery.grammar import MOST_PARAMETERS, Term, id_of
from pipeclamp_identification.discovery.shapes import STRENGTH, Entry
from pipeclamp_models.law.declaration import Declaration, ParameterTable

SHARE = "c_x"
"""Symbol of how many times the first term's strength the second one has."""
MOST_STATES = 1


def may_join(first: Term, second: Term) -> bool:
    """Tell whether two terms, no pair yet, add a force each and are few enough numbers and states for one proposal."""
    one, other = first.declaration, second.declaration
    return (
        "factor" not in (first.family, second.family)
        and all(each.symbol != SHARE for each in one.parameters)
        and len(one.parameters) + len(other.parameters) <= MOST_PARAMETERS
        and len(one.states) + len(other.states) <= MOST_STATES
    )


def joined(first: Term, second: Term, sign: float) -> Term:
    """Give two terms as one; the second one's symbols end with `_b_x`.

    Args:
        first, second: the terms, which `may_join`.
        sign: of the first one's strength: it is taken up, for a damper beside a spring may have none of its own.
    """
    one, other = first.declaration, second.declaration
    names = [*(each.symbol for each in other.parameters), *(each.symbol for each in other.states)]
    symbols = re.compile(rf"\b({'|'.join(name[:-2] for name in names)})_x\b")

    def beside(text: str) -> str:
        share = f"({'-' if sign < 0 else ''}{STRENGTH} * {SHARE})"
        return symbols.sub(lambda found: f"{found[1]}_b_x", text).replace(f"{STRENGTH[:-2]}_b_x", share)

    strength, *own = other.parameters
    share: Entry = {"symbol": SHARE, "unit": "-", "meaning": "strength of the second part over that of the first",
                    "start": 1.0, "lower": strength.lower}  # fmt: skip
    tables = [_from_one(each) for each in one.parameters]
    tables[0] |= {"upper": 0.0} if sign < 0 else {"lower": 0.0}
    further = [{**_from_one(each), "symbol": beside(each.symbol)} for each in own]
    acts_like = f"{first.acts_like}, and {second.acts_like}"
    declaration = Declaration.model_validate({
        **one.model_dump(exclude_defaults=True),
        "id": id_of(f"{one.id.removeprefix('found_')}_and_{other.id.removeprefix('found_')}"),
        "title": acts_like, "looks_like": acts_like, "parameters": (*tables, share, *further),
        "force": f"{one.force} + {beside(other.force)}",
        "states": tuple(
            {**each.model_dump(), "symbol": beside(each.symbol), "update": beside(each.update)}
            if each in other.states else each.model_dump()
            for each in (*one.states, *other.states)
        ),
        "energy": one.energy or beside(other.energy),
        "conditions": tuple(dict.fromkeys([*one.conditions, *other.conditions])),
    })  # fmt: skip
    return Term(first.family, declaration, acts_like, (one.id, *first.shorter))


def _from_one(table: ParameterTable) -> dict[str, object]:
    """Give a parameter with one start, for two terms have as many as each other by chance only."""
    return {**table.model_dump(), "start": table.start[:1]}
