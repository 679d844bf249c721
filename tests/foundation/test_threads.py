import os
import sys

import pytest

from contactqp.foundation.threads import Team, shared_team


@pytest.mark.parametrize("threads", [1, 2, 3])
@pytest.mark.parametrize("count", [1, 2, 5])
def test_strips_are_shared_and_results_keep_their_order(threads, count):
    strips = [(k, k + 1) for k in range(count)]
    with Team(threads) as team:
        assert team.run(lambda ten, first, last: (ten * first, last), strips, 10) == [
            (10 * k, k + 1) for k, _ in strips
        ]


@pytest.mark.skipif(sys.platform == "win32", reason="there is no fork")
@pytest.mark.filterwarnings("ignore:.*multi-threaded, use of fork:DeprecationWarning")
def test_a_forked_process_makes_a_team_of_its_own():
    strips = [(0, 1), (1, 2), (2, 3)]
    shared_team().run(lambda first, last: first, strips)
    child = os.fork()
    if child == 0:
        os._exit(0 if shared_team().run(lambda first, last: last, strips) == [1, 2, 3] else 1)
    assert os.waitpid(child, 0)[1] == 0
