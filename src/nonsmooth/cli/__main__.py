"""``python -m nonsmooth.cli``: the same as ``python -m nonsmooth``."""

from nonsmooth.cli import main

if __name__ == "__main__":
    main()
