"""Terms that no catalogue has: enumerated from a small grammar, searched, and guarded before one is proposed.

Every term is a declaration, as a user may write it. None can create energy, and dimensions agree, by construction.
Nothing is proposed that noise, a left-out part of the tests, or the catalogue could do as well.
"""
