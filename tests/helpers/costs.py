"""What work costs, whatever else the machine is busy with."""

import time
from collections.abc import Callable


def processor_seconds(work: Callable[[], object]) -> float:
    """Processor time of this process, all its threads together [s].

    While nothing else runs this is the time that passes, or more: waiting for a turn is no cost.
    """
    start = time.process_time()
    work()
    return time.process_time() - start
