"""Workers that are this process: jobs are done in order, and kept."""


class Here:
    """Does jobs here."""

    count = 1

    def __init__(self):
        self.jobs = []

    def each(self, work, jobs):
        for place, job in enumerate(jobs):
            self.jobs.append(job)
            yield place, work(job)

    def close(self):
        """Nothing was started."""
