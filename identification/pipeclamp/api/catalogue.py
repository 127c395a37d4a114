"""What the program knows by itself: the catalogue of effects, and the schemas of what it writes."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

from pipeclamp.api.shown import PathOrName, Told, called_from_python, declarations_of, frame_of, path_of, text_of
from pipeclamp_models.realise.catalogue_answer import (
    CatalogueAnswer,
    asked_effects,
    catalogue_answer,
    parameter_answers,
)

if TYPE_CHECKING:
    from pipeclamp.show.table import Table
    from pipeclamp_models.base.tables import pl
    from pipeclamp_models.equations.effect import Effect

COLUMNS = (
    ("effect", "name"),
    *((name, name) for name in ("id", "part", "does", "looks_like", "imitated_by", "told_apart_by", "source")),
)
"""Of a frame of effects, with what of an effect each shows."""


class Catalogue(Told):
    """Effects, by name: what each does, what imitates it, which test tells them apart.

    It iterates over names, as `identify` and `add` take them, and gives an effect by its name.

    >>> catalogue = effects()
    >>> "damping_temperature" in catalogue
    True
    >>> catalogue["damping_temperature"].to_frame()["does"].to_list()
    ['damping follows the temperature smoothly']
    """

    def __init__(self, listed: Sequence[Effect], declared: Sequence[PathOrName], *, whole: bool) -> None:
        self._effects = tuple(listed)
        self._declared = tuple(declared)
        self._whole = whole

    @property
    def names(self) -> tuple[str, ...]:
        """The effects' names."""
        return tuple(effect.name for effect in self._effects)

    def __len__(self) -> int:
        """Count them."""
        return len(self._effects)

    def __iter__(self) -> Iterator[str]:
        """Go through their names."""
        return iter(self.names)

    def __getitem__(self, name: str) -> Catalogue:
        """Give one effect whole, as `effects(name)` does.

        Raises:
            UserError: there is none of that name.
        """
        return effects(name, declared=self._declared)

    @cached_property
    def _answer(self) -> CatalogueAnswer:
        return catalogue_answer(self._effects)  # its equations take seconds to typeset

    def to_dict(self) -> dict[str, Any]:
        """Give what `pipeclamp effects --json` writes; `schema("effects")` is its schema."""
        return self._answer.to_dict()

    def to_frame(self) -> pl.DataFrame:
        """Give a row an effect: name, part (clamp, rig or base), what it does and looks like, what imitates it."""
        # the answer's equations take seconds to typeset, and are no column
        return frame_of(
            [
                {
                    name: ", ".join(value) if isinstance(value := getattr(one, of), tuple) else value
                    for name, of in COLUMNS
                }
                for one in self._effects
            ]
        )

    def parameters(self) -> pl.DataFrame:
        """Give a row a parameter: effect, symbol, unit, meaning, bounds, typical size for the loops of clamp emwm2."""
        return frame_of([{"effect": name, **one.to_dict()} for name, one in parameter_answers(self._effects)])

    def _told(self) -> tuple[Sequence[Table], Sequence[str]]:
        from pipeclamp.show import effects as shown

        if not self._whole:
            return [shown.overview(self._effects)], []
        one = self._effects[0]
        return shown.tables_of(one), [*shown.equation_lines(one), *shown.about_lines(one)[1:]]

    def __str__(self) -> str:
        """Give names and what they do; of one effect its equations, and what is said of it."""
        tables, lines = self._told()
        return "\n".join(lines or (f"{name}: {does}" for name, _, does, _ in tables[0].rows))

    def __repr__(self) -> str:
        """Give how many there are, or which one."""
        return f"<effect {self.names[0]}>" if self._whole else f"<{len(self)} effects>"


@called_from_python()
def effects(effect: PathOrName | None = None, *, declared: Iterable[PathOrName] = ()) -> Catalogue:
    """Give the catalogue of effects, or one effect whole.

    Args:
        effect: the effect's name, or the path of a declaration (F.toml); all unless told.
        declared: declarations of your own effects by path (F.toml), which join the catalogue.

    Raises:
        UserError: there is no such effect, or a declaration can't serve.

    >>> effects("memory").parameters()["symbol"].to_list()
    ['k_s', 'z_s']
    """
    paths = declarations_of(declared)
    name = None if effect is None else path_of(effect, "an effect")
    return Catalogue(asked_effects(name, paths), [str(path) for path in paths], whole=name is not None)


def schema(name: str = "law") -> dict[str, Any]:
    """Give the JSON schema of parameter files, or of an answer's `to_dict()`.

    Args:
        name: law, metrics, comparison, laws-comparison, system-comparison, diagnosis, discovery, band-plan,
            campaign-plan, import or effects.

    Raises:
        UserError: there is no schema of that name.

    >>> schema("comparison")["anyOf"][0]
    {'$ref': '#/$defs/ComparisonAnswer'}
    """
    from pipeclamp_identification.workflow.schemas import schema_text

    found: dict[str, Any] = json.loads(schema_text(text_of(name, "name", "law")))
    return found
