"""What libraries print and warn of is kept from the user, and nothing else is."""

import os
import threading
import warnings

import pytest

from contactqp.foundation.quiet import output_discarded, warnings_ignored


def test_warnings_are_ignored_inside_and_errors_again_outside():
    with warnings_ignored():
        warnings.warn("inside", stacklevel=1)
    with pytest.raises(UserWarning, match="outside"):
        warnings.warn("outside", stacklevel=1)


def test_filters_are_as_before_once_the_last_thread_has_left():
    before = list(warnings.filters)
    inside, leave = threading.Barrier(3), [threading.Event(), threading.Event()]

    def work(number):
        with warnings_ignored():
            inside.wait(10.0)
            leave[number].wait(10.0)
            warnings.warn("nobody hears it", stacklevel=1)

    threads = [threading.Thread(target=work, args=(number,)) for number in range(2)]
    for thread in threads:
        thread.start()
    inside.wait(10.0)
    for number, thread in enumerate(threads):  # the first one in is the first one out
        leave[number].set()
        thread.join()
    assert list(warnings.filters) == before


def test_output_of_compiled_code_is_discarded_for_a_moment(capfd):
    os.write(1, b"before ")
    with output_discarded():
        os.write(1, b"by compiled code")
        os.write(2, b"by compiled code")
    print("after", flush=True)
    assert capfd.readouterr() == ("before after\n", "")


def test_output_comes_back_after_an_error(capfd):
    with pytest.raises(ZeroDivisionError), output_discarded():
        raise ZeroDivisionError
    os.write(1, b"heard")
    assert capfd.readouterr().out == "heard"
