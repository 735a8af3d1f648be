"""What theory says: waits of queues, the repairman, and what lanes and corners let through."""

import math

import numpy as np


def m_m_c_wait(rate, service, servers):
    """Mean wait of M/M/c, by Erlang's formula of delay (1917)."""
    offered = rate * service
    terms = [offered**n / math.factorial(n) for n in range(servers)]
    full = offered**servers / math.factorial(servers) * servers / (servers - offered)
    return full / (sum(terms) + full) * service / (servers - offered)


def m_g_1_wait(rate, mean, square):
    """Mean wait of M/G/1 from the mean and the mean square of the service: Pollaczek (1930) and Khinchine (1932)."""
    return rate * square / (2 * (1 - rate * mean))


def completion(mean, square, every, repair, repair_square):
    """Mean and mean square of a service with the repairs of a server that breaks down while it serves (Gaver 1962).

    Breakdowns come after exponential times of service, and the service is resumed: there are as many as in a Poisson
    process over the service, each adds a repair.
    """
    longer = 1 + repair / every
    return mean * longer, square * longer**2 + mean * repair_square / every


def on_and_off(up, every, repair):
    """Part of the time that a charger that was in order `up` ago is in repair; both times exponential."""
    return repair / (every + repair) * (1 - math.exp(-up * (1 / every + 1 / repair)))


def m_d_c_wait(rate, service, servers):
    """Mean wait of M/D/c, exactly: every customer in service now is gone one service time later (Crommelin 1932)."""
    most = servers + 400
    arrivals = np.array(
        [math.exp(n * math.log(rate * service) - rate * service - math.lgamma(n + 1)) for n in range(most)]
    )
    present = np.zeros(most)
    present[0] = 1.0
    for _ in range(5000):
        left = np.concatenate(([present[: servers + 1].sum()], present[servers + 1 :]))
        after = np.convolve(left, arrivals)[:most]
        if abs(after - present).max() < 1e-14:
            break
        present = after
    queue = sum((n - servers) * present[n] for n in range(servers, most))
    return queue / rate


def repairman(machines, up, repair):
    """Part of the time that one repairman is busy; up times exponential, repair constant (Takacs, M/G/1//N)."""
    product, total = 1.0, 1.0
    for i in range(1, machines):
        product *= math.exp(i * repair / up) - 1  # (1 - f) / f, with f the transform of a constant
        total += math.comb(machines - 1, i) * product
    return 1 - 1 / (1 + machines * repair / up * total)


def repairmen(machines, repairers, up, repair):
    """Repairs per time unit of machines by some repairers, first come, first served (M/M/c//N).

    Repair times are exponential. How up times are distributed does not matter, as nobody queues in them.
    """
    weight, total, busy = 1.0, 0.0, 0.0
    for broken in range(machines + 1):
        at_work = min(broken, repairers)
        total += weight
        busy += weight * at_work
        weight *= (machines - broken) * repair / up / min(broken + 1, repairers)
    return busy / total / repair


def repair_with_spares(machines, spare, up, repair):
    """Failures per time unit of machines with spares, each repaired by itself; up times exponential.

    A birth and death process in the number in repair. How repair times are distributed does not matter (Palm).
    """
    alive, total, failures = 1.0, 0.0, 0.0
    for broken in range(machines + spare + 1):
        rate = min(machines, machines + spare - broken) / up
        total += alive
        failures += alive * rate
        alive *= rate / ((broken + 1) / repair)
    return failures / total


def held_up(rate, stay, away):
    """How often a robot finds people in an aisle `away` after it last found it empty; M/M/infinity.

    From empty, the number of people after a time t is a Poisson number of mean rate x stay x (1 - exp(-t / stay)).
    """
    return 1 - math.exp(-rate * stay * (1 - math.exp(-away / stay)))


def wait_until_empty(rate, stay, away, most=60):
    """The mean time that the same robot waits for the aisle to be empty, 0 included.

    From n people to none one goes down step by step; a step down from k takes, by the balance of a birth and death
    process with probabilities p, (p_k + p_(k+1) + ...) / (p_k k / stay) on average.
    """
    load = rate * stay
    weights = [load**k / math.factorial(k) for k in range(2 * most)]
    down = [0.0] + [sum(weights[k:]) / (weights[k] * k / stay) for k in range(1, most)]
    present = load * (1 - math.exp(-away / stay))
    chance = [math.exp(-present) * present**n / math.factorial(n) for n in range(most)]
    return sum(p * sum(down[: n + 1]) for n, p in enumerate(chance))


def headway_of_a_turn(angle, theta, distance, speed, node_time=0.0):
    """Time between two robots that turn off one after the other, `distance` apart.

    The next sets out from D before the node once it will never be nearer than D to the one ahead and look at it
    within theta of its heading: when that one is g - D beyond, g = D cos(angle/2 - a) / cos(angle/2), a at most theta.
    """
    a = min(theta, angle / 2)
    beyond = distance * math.cos(angle / 2 - a) / math.cos(angle / 2) - distance
    return (distance + beyond) / speed + node_time
