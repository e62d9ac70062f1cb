"""What is packed comes back to the byte, and is worth it."""

from __future__ import annotations

from pathlib import Path
from threading import Event

import numpy as np
import pytest

pytest.importorskip('rclpy')
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image, PointCloud2, PointField
from std_msgs.msg import String
import zstandard

from bpc_perception.recording import capture_packing
from bpc_perception.recording.bag import Bag, BagError
from bpc_perception.recording.bag_writer import begin_recording
from bpc_perception.recording.capture_packing import CapturePacker, Entry, packed
from bpc_perception.recording.recovery import recover_bag
from bpc_perception.recording.storage import planes
from bpc_perception.recording.storage.packing import unpacked
from bpc_perception.recording.storage.storage import open_storage

pytestmark = pytest.mark.ros
WIDTH, HEIGHT = 64, 48
SAMPLE = Path(__file__).resolve().parents[3] / 'bags' / 'spiral_gaps'


def image(channels: int = 4, padding: int = 0, seed: int = 0) -> Image:
    """A picture with a little noise."""
    rng = np.random.default_rng(seed)
    values = np.clip(rng.normal(128, 3, (HEIGHT, WIDTH * channels + padding)), 0, 255)
    return Image(height=HEIGHT, width=WIDTH, encoding='rgba8' if channels == 4 else 'mono8',
                 step=WIDTH * channels + padding, data=values.astype(np.uint8).tobytes())


def cloud(step: int = 16, missing: float = 0.2) -> PointCloud2:
    """A plane with noise in which points are missing."""
    rng = np.random.default_rng(1)
    points = np.zeros((HEIGHT * WIDTH, step), np.uint8)
    xyz = np.stack((*np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT)),
                    np.full((HEIGHT, WIDTH), 300.0)), axis=-1).reshape(-1, 3)
    xyz = (xyz + rng.normal(0, 0.04, xyz.shape)) / 1000
    xyz[rng.random(len(xyz)) < missing] = np.nan
    points[:, :12] = xyz.astype(np.float32).view(np.uint8)
    fields = [PointField(name=name, offset=4 * place, datatype=PointField.FLOAT32, count=1)
              for place, name in enumerate('xyz')]
    return PointCloud2(height=HEIGHT, width=WIDTH, fields=fields, point_step=step,
                       row_step=WIDTH * step, data=points.tobytes(), is_dense=False)


@pytest.mark.parametrize('message', [
    image(), image(channels=3), image(channels=1), image(channels=1, padding=5), cloud(),
    cloud(12), cloud(32), cloud(18), cloud(missing=1.0)])
def test_a_packed_message_comes_back_to_the_byte(message: Image | PointCloud2) -> None:
    data = serialize_message(message)
    found = packed(data, type(message))
    assert found.startswith(planes.MAGIC)
    assert len(found) < len(data)
    assert unpacked(found) == data


def noise() -> bytes:
    """A picture of which nothing can be told from its neighbours."""
    values = np.random.default_rng(2).integers(0, 256, HEIGHT * WIDTH * 4, np.uint8)
    return bytes(serialize_message(Image(height=HEIGHT, width=WIDTH, step=WIDTH * 4,
                                         data=values.tobytes())))


@pytest.mark.parametrize(('data', 'kind'), [
    (noise(), Image), (serialize_message(Image()), Image), (b'', Image),
    (serialize_message(PointCloud2()), PointCloud2), (b'\0\1\0\0torn', PointCloud2),
    (serialize_message(Image(height=2, width=2, step=9, data=bytes(18))), Image)],
    # The bytes between two fields are whatever was there: no name of a test.
    ids=['noise', 'no pixels', 'nothing', 'no points', 'torn', 'odd rows'])
def test_what_is_not_made_so_that_it_helps_stays_as_it_is(data: bytes, kind: type) -> None:
    assert packed(data, kind) == data


def test_captures_take_less_than_half_of_their_room() -> None:
    kinds = {'/color/image_color': Image, '/points/xyzrgba': PointCloud2}
    bag = Bag(SAMPLE)
    before = after = 0
    for topic, _, message in bag.messages(set(kinds)):
        data = serialize_message(message)
        before += len(data)
        after += len(packed(data, kinds[topic]))
    assert before > 5_000_000
    assert after < 0.5 * before


@pytest.mark.parametrize('spoiled', [
    planes.MAGIC, planes.MAGIC + bytes(40), b'cut', b'flipped', b'longer', b'bomb'])
def test_a_damaged_one_is_refused(spoiled: bytes) -> None:
    good = packed(serialize_message(cloud()), PointCloud2)
    bomb = zstandard.ZstdCompressor().compressobj(size=planes.LARGEST_BYTES + 16)
    head = planes.HEAD.pack(planes.MAGIC, 0, 0, 16, 3)
    data = {
        b'cut': good[:-100], b'flipped': good[:-400] + bytes([good[-400] ^ 255]) + good[-399:],
        b'longer': planes.HEAD.pack(planes.MAGIC, 1 << 31, 8, 16, 3) + good[planes.HEAD.size:],
        b'bomb': head + bomb.compress(bytes(16)) + bomb.flush(zstandard.COMPRESSOBJ_FLUSH_BLOCK),
    }.get(spoiled, spoiled)
    with pytest.raises(BagError, match='expected a packed capture'):
        unpacked(data)


def test_messages_come_in_order_and_none_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    go_on = Event()

    def slowly(data: bytes, _: type) -> bytes:
        assert go_on.wait(60)
        return data.upper()

    monkeypatch.setattr(capture_packing, 'packed', slowly)
    packer = CapturePacker({'/image': Image, '/words': String})
    assert all(packer.take(Entry('/image', number, b'%da' % number)) for number in range(6))
    assert not packer.take(Entry('/words', 9, b'word'))
    assert list(packer.packed()) == []
    go_on.set()
    # Four at a time are packed; what has no time keeps its turn.
    assert list(packer.rest()) == [
        Entry('/image', number, b'%dA' % number if number < 4 else b'%da' % number)
        for number in range(6)]


def test_what_is_packed_already_makes_room(monkeypatch: pytest.MonkeyPatch) -> None:
    done = Event()
    monkeypatch.setattr(capture_packing, 'packed', lambda data, _: data.upper())
    packer = CapturePacker({'/image': Image})
    for number in range(9):
        done.clear()
        packer.take(Entry('/image', number, b'a'))
        packer._waiting[-1][1].add_done_callback(lambda _: done.set())
        assert done.wait(60)
    assert [entry.data for entry in packer.packed()] == [b'A'] * 9
    assert list(packer.rest()) == []


def test_a_damaged_message_is_left_out_when_the_rest_is_recovered(
        tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    good = packed(serialize_message(image()), Image)
    with begin_recording(tmp_path / 'bag', {'/image': 'sensor_msgs/msg/Image'}, {},
                         {'/image'}) as writer:
        for number, data in enumerate((good, good[:-50], good)):
            writer.write('/image', number, data)
    assert recover_bag(tmp_path / 'bag', tmp_path / 'new').messages == {'/image': 2}
    assert 'left out a message on /image: expected a packed capture' in caplog.text
    assert len(list(Bag(tmp_path / 'new').messages({'/image'}))) == 2


def test_a_packed_recording_is_read_as_it_is_and_recovered_for_others(tmp_path: Path) -> None:
    kinds = {'/image': 'sensor_msgs/msg/Image', '/points': 'sensor_msgs/msg/PointCloud2',
             '/words': 'std_msgs/msg/String'}
    messages = {'/image': image(), '/points': cloud(), '/words': String(data='word')}
    with begin_recording(tmp_path / 'bag', kinds, {}, {'/image', '/points'}) as writer:
        # Twice serialized, bytes between fields may differ.
        data = {topic: serialize_message(message) for topic, message in messages.items()}
        for number, (topic, message) in enumerate(messages.items()):
            writer.write(topic, number, packed(data[topic], type(message)))
        writer.write('/image', 5, image(seed=7))  # one for which there was no time
    found = list(Bag(tmp_path / 'bag').messages(set(kinds)))
    assert [entry.message for entry in found] == [*messages.values(), image(seed=7)]
    recover_bag(tmp_path / 'bag', tmp_path / 'plain')
    assert list(Bag(tmp_path / 'plain').messages(set(kinds))) == found
    raw = list(open_storage(tmp_path / 'plain' / 'plain_0.mcap').messages())
    assert {each.channel.encoding for each in raw} == {'cdr'}
    assert [each.data for each in raw[:3]] == list(data.values())
