import threading

from conf.call.shared_objects import SharedObjectSender
from conf.protocol.portrait.chunk_budget import ChunkBudget
from conf.protocol.portrait.chunks import decode_chunk
from conf.protocol.portrait.object_receiver import ObjectReceiver


def test_nothing_is_sent_until_images_are_allowed() -> None:
    objects, budget = SharedObjectSender(), ChunkBudget(4.0)
    objects.send_object(0, b"image", priority=0)
    assert all(objects.next_chunk(now / 10, budget) is None for now in range(50))
    objects.is_allowed = True
    chunk = objects.next_chunk(5.0, budget)
    assert chunk is not None and decode_chunk(chunk).data == b"image"
    objects.is_allowed = False
    objects.restart()
    assert objects.next_chunk(9.0, budget) is None


def test_an_object_arrives_and_is_known_to_have_arrived() -> None:
    objects, receiver = SharedObjectSender(), ObjectReceiver(7)
    objects.is_allowed = True
    objects.send_object(3, bytes(500), priority=1)
    budget, received, now = ChunkBudget(40.0), None, 0.0
    while received is None:
        now += 0.05
        if (chunk := objects.next_chunk(now, budget)) is not None:
            received = receiver.receive_chunk(chunk)
    assert received == bytes(500) and objects.waiting_bytes > 0 and not objects.delivered(3)
    ack = None
    while ack is None:
        now += 0.1
        ack = receiver.next_ack(now)
    assert not objects.receive_ack(ack)
    assert objects.delivered(3) and objects.waiting_bytes == 0
    objects.cancel(3)
    assert not objects.delivered(3)


def test_two_threads_may_fill_and_send_at_once() -> None:
    objects, budget = SharedObjectSender(), ChunkBudget(1e6)
    objects.is_allowed = True
    errors: list[Exception] = []

    def fill() -> None:
        try:
            for number in range(2000):
                objects.send_object(number % 7, bytes(400), priority=0)
                objects.cancel((number + 3) % 7)
        except Exception as error:
            errors.append(error)

    thread = threading.Thread(target=fill)
    thread.start()
    now = 0.0
    while thread.is_alive():
        now += 0.01
        objects.next_chunk(now, budget)
        assert objects.waiting_bytes >= 0
    thread.join()
    assert errors == []
