"""How much of the machine other programs used while the suite measured."""
import os
import resource
import time

TICK = os.sysconf("SC_CLK_TCK")


class Clock:
    """CPU seconds from now on: of this program and the runs that ended, and of the whole machine."""

    def __init__(self):
        self.began, self.own, self.machine = time.monotonic(), own_seconds(), machine_seconds()

    def others(self):
        """Cores that other programs, the system and the host of a virtual machine used on average, or
        None where the kernel does not say. Runs that still go on count as others."""
        if not self.machine:
            return None
        used = machine_seconds() - self.machine - (own_seconds() - self.own)
        return max(0.0, used / (time.monotonic() - self.began))


def own_seconds():
    return sum(usage.ru_utime + usage.ru_stime
               for usage in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)))


def machine_seconds():
    """CPU seconds of all programs since the start, time that the host took away included."""
    try:
        with open("/proc/stat") as file:
            user, nice, system, _, _, irq, softirq, steal = map(int, file.readline().split()[1:9])
    except (OSError, ValueError):
        return None
    return (user + nice + system + irq + softirq + steal) / TICK


def wait_for_quiet(say, seconds=120, limit=0.1):
    """Waits until other programs use less than `limit` cores for three seconds, at most `seconds`.
    Returns what they used at last."""
    end, waits = time.monotonic() + seconds, False
    while True:
        clock = Clock()
        time.sleep(3)
        used = clock.others()
        if used is None or used < limit or time.monotonic() > end:
            return used
        if not waits:
            say(f"other programs use {used:.1f} cores: waiting until the machine is quiet")
        waits = True
