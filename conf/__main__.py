"""`python -m conf` is `conf`."""

from conf.cli import main

main()
