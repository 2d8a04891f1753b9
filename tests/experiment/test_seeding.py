"""Named random streams."""

import numpy as np

from deformpush.experiment.seeding import generator


def test_seed_and_name_give_the_same_numbers_again():
    np.testing.assert_array_equal(generator(7, "task").random(5), generator(7, "task").random(5))


def test_names_and_seeds_give_streams_of_their_own():
    streams = [
        generator(seed, name).random(2000) for seed in (0, 1, 2) for name in ("task", "optimizer", "x")
    ]
    between = np.corrcoef(streams)[~np.eye(9, dtype=bool)]
    assert np.abs(between).max() < 0.1  # 4.5 standard deviations of independent streams


def test_one_stream_is_not_moved_by_drawing_from_another():
    alone = generator(3, "optimizer").random(4)
    generator(3, "task").random(100)
    np.testing.assert_array_equal(generator(3, "optimizer").random(4), alone)


def test_the_streams_of_old_runs_stay_as_they_are():
    """NumPy keeps raw streams for good, so a change here is a change of the derivation."""
    assert generator(0, "task").bit_generator.random_raw() == 17624046806433040433
    assert generator(12, "optimizer").bit_generator.random_raw() == 9096636841898461186
