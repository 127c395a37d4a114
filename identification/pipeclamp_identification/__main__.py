"""`python -m pipeclamp_identification` is `pipeclamp`."""

from pipeclamp_identification.cli import main

main()
