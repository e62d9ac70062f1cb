"""Small pictures of a print stay small, however many there are."""

from dataclasses import replace

import numpy as np

from bpc_perception.core.result import Result
from bpc_perception.report.thumbnails import decode, encode, MOST_PICTURES, Thumbnails


def test_pictures_stay_within_their_budget(result):
    noise = np.random.default_rng(0).integers(0, 256, (24, 32, 3), np.uint8)
    noisy = Result(replace(result.capture, image=noise), refusal='noise')
    assert len(encode(noise, 10**6)[0]) > 1500
    for expected in (40, None):
        thumbnails = Thumbnails(expected, budget=100_000)
        for _ in range(40):
            thumbnails.add(noisy)
            assert sum(map(len, thumbnails.pictures.values())) <= 100_000
        assert list(thumbnails.pictures) == list(range(40))
        assert decode(thumbnails.pictures[0]).shape[1] > 10


def test_of_very_many_captures_some_are_pictured(result):
    thumbnails = Thumbnails()
    for _ in range(2 * MOST_PICTURES + 3):
        thumbnails.add(result)
    numbers = list(thumbnails.pictures)
    assert MOST_PICTURES / 2 < len(numbers) <= MOST_PICTURES
    assert numbers[-1] == 2 * MOST_PICTURES + 2
    assert set(np.diff(numbers[:-1])) == {4}
