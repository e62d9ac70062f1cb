"""A capture whose image or cloud never came is counted, once."""

from bpc_perception.recording.torn_captures import PATIENCE_S, TornCaptures


def test_a_capture_whose_cloud_never_came_is_counted_once() -> None:
    torn = TornCaptures('info', ('image', 'cloud'))
    for topic in ('cloud', 'info', 'image', 'pose'):
        torn.add(topic, 1, 0.0)
    torn.add('info', 2, 1.0)
    torn.add('image', 2, 1.1)
    torn.add('info', 3, 1.2)
    assert torn.take(1.0 + PATIENCE_S) == 0
    torn.add('image', 3, 3.1)
    torn.add('cloud', 3, 3.1)
    assert torn.take(1.1 + PATIENCE_S) == 1
    torn.add('cloud', 2, 20.0)  # too late, and no capture of its own
    assert torn.take(30.0) == 0
    assert not torn._came
