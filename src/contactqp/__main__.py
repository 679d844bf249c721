"""``python -m contactqp``: the command ``contactqp``."""

from contactqp_command import main

if __name__ == "__main__":
    main()
