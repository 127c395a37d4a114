"""Laws beyond the catalogue and beyond the words of the grammar that terms are discovered in.

plain, states, factors: the laws. registry: which there are, with equation, source and kind. cases, judge, form, table:
as the modules of these names beside this folder; form says whether a proposed term is what is hidden. None of the first
four shares code with the package that is put to the test.
"""
