# SPDX-License-Identifier: Apache-2.0
"""How long a recorded process would take on a machine of P cores: list scheduling (R. L. Graham, "Bounds on
multiprocessing timing anomalies", 1969) of what scrim_loops records (src/scrim/base/loop_recorder.h).

A core that is free takes the next task of the loop. The loops within a task share the cores that the tasks of the
outer loop leave: if these are fewer than the cores, each has as many. Where the first task does nearly all, since the
tasks share the work out among themselves (the passes of soft light), it counts as shared evenly. It is an upper bound of what is gained: memory is
as fast for all cores as for one, no task waits for another of its loop, and each core is as fast as the one recorded.
"""

import heapq
from dataclasses import dataclass, field

HANDS_OUT = 0.95  # of the work in the first task: the loop's tasks share it out among themselves
BARRIER = 5e-6  # seconds that it takes to begin and end a loop with several threads


@dataclass
class Loop:
    tasks: list  # of each the seconds, or a list of seconds and loops, one after the other

    def seconds(self, cores):
        if cores == 1 or len(self.tasks) <= 1:
            return sum(seconds_of(task, cores) for task in self.tasks)
        work = self.seconds(1)
        if seconds_of(self.tasks[0], 1) > HANDS_OUT * work:
            return work / min(cores, len(self.tasks)) + BARRIER
        each = max(1, cores // len(self.tasks))
        free = [0.0] * min(cores, len(self.tasks))
        for task in self.tasks:
            heapq.heappush(free, heapq.heappop(free) + seconds_of(task, each))
        return max(free) + BARRIER


def seconds_of(parts, cores):
    """What comes one after the other: seconds, or a list of seconds and loops."""
    if isinstance(parts, float):
        return parts
    return sum(part if isinstance(part, float) else part.seconds(cores) for part in parts)


@dataclass
class Record:
    parts: list = field(default_factory=list)  # of the process: seconds and loops
    tasks: int = 0

    def seconds(self, cores):
        return seconds_of(self.parts, cores)

    def serial(self):
        """Seconds outside of all loops."""
        return sum(part for part in self.parts if isinstance(part, float))

    def loops(self):
        return [part for part in self.parts if isinstance(part, Loop)]


def read_record(path):
    """Reads the lines of a record: S, L and T, with nanoseconds or a number of tasks."""
    record = Record()
    open_loops = []  # of loops that have begun: the loop, the tasks that are left, the parts of the present task
    parts = record.parts
    with open(path) as lines:
        for line in lines:
            kind, number = line.split()
            if kind == "S":
                parts.append(1e-9 * int(number))
            elif kind == "L":
                loop = Loop([])
                parts.append(loop)
                if int(number):
                    open_loops.append([loop, int(number), parts])
                    parts = []
            else:
                record.tasks += 1
                loop, left, outer = open_loops[-1]
                last = 1e-9 * int(number)
                loop.tasks.append(last if not parts else parts + [last])
                open_loops[-1][1] = left - 1
                parts = []
                if left == 1:
                    open_loops.pop()
                    parts = outer
    if open_loops:
        raise ValueError(f"{path}: the record ends within a loop")
    return record
