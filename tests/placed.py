"""An object that tests place in another process, where this module is found as it is here."""

import os
import signal
import time


class Counter:
    """It counts its calls."""

    def __init__(self, first):
        if first < 0:
            raise ValueError(f"first must be >= 0, got {first}")
        self.count = first

    def add(self, number):
        self.count += number
        return self.count

    def refuse(self, text):
        raise KeyError(text)

    def refuse_in_own_words(self, text):
        class LocalError(Exception):
            pass

        raise LocalError(text)

    def say(self, text):
        os.write(1, text.encode())
        return len(text)

    def blocked(self):
        return signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ())

    def end(self, code):
        os._exit(code)

    def wait(self):
        time.sleep(60.0)
