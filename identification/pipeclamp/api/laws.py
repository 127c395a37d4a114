"""Laws made from tests: identified, with an effect more, with one less, fitted anew."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import fspath
from pathlib import Path
from typing import get_args

from pipeclamp.api.diagnosis import Diagnosis
from pipeclamp.api.law import Law, opened
from pipeclamp.api.shown import PathOrName, called_from_python, numbers_by_name, path_of, several, text_of
from pipeclamp.api.tests import Tests, tested
from pipeclamp_identification.fitting.identify import Method
from pipeclamp_identification.workflow.change import add_effects, remove_effect
from pipeclamp_identification.workflow.change import refit as refitted
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.law.declaration_files import read_effects
from pipeclamp_models.law.file import NamedKind, Provenance
from pipeclamp_models.law.law import Structure


@called_from_python()
@one_thread()
def identify(
    tests: Tests | PathOrName,
    effects: PathOrName | Sequence[PathOrName] = (),
    base: str = "power",
    *,
    method: Method = "joint",
    freeze: Mapping[str, float] | None = None,
    name: str | None = None,
    progress: Progress = silent,
) -> Law:
    """Fit a law to all runs of a campaign at once.

    Args:
        tests: the tests, or their folder or bundled name.
        effects: effects of the catalogue by name, one or several, or declarations of your own by path (F.toml).
        base: "power" (Eq. 17 of Symmetry 2020, 12(8), 1283), "memory" (Eq. 14) or "series" (Eq. 10).
        method: "joint", or "surfaces", the paper's route by itself.
        freeze: values of parameters that are held, by name.
        name: of the law; the campaign's by default.
        progress: is told what is being done.

    Returns:
        the law, with the uncertainty of its parameters.

    Raises:
        UserError: an unknown base or effect, or tests that can't determine the law.

    >>> from pipeclamp import read_campaign
    >>> law = identify(read_campaign("clamp_a"), effects=["damping_temperature"])
    >>> law
    <law clamp_a: power + damping_temperature>
    >>> print(f"{law.nrmse:.2%}, k10 = {law.values['k10']:.0f} N/mm")
    1.29%, k10 = 1451 N/mm
    """
    tests = tested(tests)
    effects = several(effects)
    names, declarations = read_effects([path_of(effect, "an effect") for effect in effects], ())
    called_so = tests.name if name is None else text_of(name, "name", "clamp 7") or tests.name
    held = tuple(sorted(numbers_by_name(freeze, "freeze", '{"alpha0": 0.4}').items()))
    structure = Structure(text_of(base, "base", "power"), tuple(names), held).with_declared(declarations)
    found = tests.tests.identify(structure, method=method, progress=progress)
    called = f"{_read(tests)}, effects={[fspath(effect) for effect in effects]!r}, base={base!r}"
    return Law(found.file(name=called_so, provenance=Provenance(f"pc.identify({called})")))


@one_thread()
def identify_per(
    tests: Tests | PathOrName,
    column: str,
    effects: PathOrName | Sequence[PathOrName] = (),
    base: str = "power",
    *,
    progress: Progress = silent,
) -> dict[str, Law]:
    """Fit a law to each group of a text column of runs.csv by itself; other arguments as of `identify`.

    Args:
        tests: the tests, or their folder or bundled name.
        column: specimen, or another column of texts.
        effects, base, progress: as of `identify`.

    Returns:
        the law of each group, by its name.

    Raises:
        UserError: there is no such column, or a group has too few runs, or can't determine the law.

    >>> try:
    ...     identify_per("clamp_a", "valve")
    ... except UserError as error:
    ...     print(error)
    column: got 'valve'; expected a column of texts in runs.csv, which has specimen
    """
    from pipeclamp_identification.workflow.per_group import identify_per as fitted

    tests = tested(tests)
    effects = several(effects)
    names, declarations = read_effects([path_of(effect, "an effect") for effect in effects], ())
    structure = Structure(text_of(base, "base", "power"), tuple(names)).with_declared(declarations)
    laws = fitted(tests.tests, text_of(column, "column", "specimen"), structure, progress=progress)
    shown = [fspath(effect) for effect in effects]
    called = f"pc.identify_per({_read(tests)}, {column!r}, effects={shown!r}, base={base!r})"
    return {
        law.group: Law(
            law.found.file(name=f"{tests.name} {law.group}", provenance=Provenance(f"{called}[{law.group!r}]"))
        )
        for law in laws
    }


@one_thread()
def add(
    law: Law | PathOrName,
    effect: PathOrName | Sequence[PathOrName] | Diagnosis,
    tests: Tests | PathOrName,
    *,
    kind: NamedKind | None = None,
    progress: Progress = silent,
) -> Law:
    """Add an effect to a law and refit everything; a diagnosis that names two which help only together adds both.

    Args:
        law: the law, or its file or bundled name.
        effect: an effect of the catalogue by name, a declaration of your own by path (F.toml), several of them, or the
            diagnosis that names it.
        tests: what it is refitted to.
        kind: how a diagnosis meant an effect that is given by name: beside a part nothing is called the cause later.
        progress: is told what is being done.

    Returns:
        the law with the effect; its history holds the error on left-out conditions before and after.

    Raises:
        UserError: the diagnosis names no single effect, the effect isn't known or is there already, or the tests can't
            serve it.

    >>> from pipeclamp import read_campaign
    >>> tests = read_campaign("clamp_a")
    >>> print(add(identify(tests), "damping_temperature", tests))
    clamp_a: power + damping_temperature; error 1.29% of the rms force (scatter 0.47%)
    power: error on left-out conditions 2.86%
    + damping_temperature: error on left-out conditions 1.37%
    In the middle of its tests (A 0.446 mm, f 2.24 Hz, T 160 °C): 2029 ± 2 N/mm and 0.229 ± 0.002 J a cycle.
    c_T2 and c_T3 can hardly be told apart (correlation -0.987).
    c_T1 and c_T2 can hardly be told apart (correlation -0.954).
    """
    file, tests = opened(law).file, tested(tests)
    if kind is not None and kind not in (kinds := get_args(NamedKind)):
        raise UserError(f"kind: got {kind!r}; expected {' or '.join(map(repr, kinds))}")
    if isinstance(effect, Diagnosis):
        if effect.verdict != "missing":
            raise UserError(
                f"add: the diagnosis says {effect.verdict!r}, which names no single effect; expected one of yours by "
                'name, such as add(law, "memory", tests)'
            )
        names, kind, declarations = effect.together or effect.effects, effect.kind, effect.declared
    else:
        names, declarations = read_effects((path_of(name, "an effect or a diagnosis") for name in several(effect)), ())
        if not names:
            raise UserError('add: got no effect; expected one by name, such as add(law, "memory", tests)')
    named = repr(names[0] if len(names) == 1 else names)
    meant = f", kind={kind!r}" if kind == "part" else ""
    command = f"pc.add({_named(law)}, {named}, {_read(tests)}{meant})"
    steps = add_effects(
        file, names, tests.tests, provenance=Provenance(command), declared=declarations, kind=kind, progress=progress
    )
    return Law(steps[-1].after, steps=len(steps))


@one_thread()
def remove(law: Law | PathOrName, effect: str, tests: Tests | PathOrName, *, progress: Progress = silent) -> Law:
    """Take an effect out of a law and refit the rest; arguments as of `add`.

    Raises:
        UserError: the law hasn't got the effect, or the tests can't serve it.

    >>> from pipeclamp import read_campaign
    >>> remove("emwm2", "contact_growth", read_campaign("emwm2_tables"))
    <law emwm2: power + damping_temperature + stiffness_frequency>
    """
    tests = tested(tests)
    command = f"pc.remove({_named(law)}, {effect!r}, {_read(tests)})"
    return Law(
        remove_effect(opened(law).file, effect, tests.tests, provenance=Provenance(command), progress=progress).after
    )


@one_thread()
def refit(law: Law | PathOrName, tests: Tests | PathOrName, *, progress: Progress = silent) -> Law:
    """Fit a law with its effects to tests anew, as where others have joined; arguments as of `add`.

    What is held stays held, and the law's history goes on.

    Raises:
        UserError: the tests can't serve the law.

    >>> from pipeclamp import read_campaign
    >>> refit("emwm2", read_campaign("emwm2_tables"))
    <law emwm2: power + damping_temperature + contact_growth + stiffness_frequency>
    """
    tests = tested(tests)
    command = f"pc.refit({_named(law)}, {_read(tests)})"
    return Law(refitted(opened(law).file, tests.tests, provenance=Provenance(command), progress=progress).after)


def _read(tests: Tests) -> str:
    return f"pc.read_campaign({Path(tests.origin).name!r})"


def _named(law: Law | PathOrName) -> str:
    return f"pc.open_law({Path(opened(law).origin).name!r})"
