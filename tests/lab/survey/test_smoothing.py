"""How a vehicle really moved, as its poses tell afterwards."""

import numpy as np

from fledge.lab.survey.smoothing import GAP, smooth

T = 0.01 * np.arange(400)
WAY = np.stack([np.sin(3.0 * T), 0.5 * T**2], axis=1)
SPEED = np.stack([3.0 * np.cos(3.0 * T), T], axis=1)


def test_slopes_are_found_and_are_not_late():
    found = smooth(T, WAY)
    assert np.abs((found.slope - SPEED)[found.known]).max() < 0.003
    assert np.abs((found.value - WAY)[found.known]).max() < 1e-4


def test_noise_is_mostly_gone():
    noisy = WAY + 0.0005 * np.random.default_rng(0).standard_normal(WAY.shape)
    found = smooth(T, noisy)
    assert (found.slope - SPEED)[found.known].std() < 0.03 < np.gradient(noisy - WAY, 0.01, axis=0).std()


def test_a_frame_may_be_missing_and_poses_may_repeat():
    seen = np.delete(np.arange(400), [100, 200, 201])
    again = np.sort(np.append(seen, [50, 50]))
    found = smooth(T[again], WAY[again])
    assert np.abs((found.slope - SPEED[again])[found.known]).max() < 0.06
    assert found.known[again == 100 - 1].all(), "a single frame is bridged"
    assert not found.known[(again > 196) & (again < 205)].any(), "two are not"
    assert T[202] - T[199] > GAP


def test_the_ends_are_not_known():
    known = smooth(T, WAY).known
    assert not known[:4].any() and not known[-4:].any() and known[10:-10].all()
