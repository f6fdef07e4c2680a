import asyncio
import threading
import time

from app.engine.mailboxes.latest import Latest


def test_the_newest_value_wins():
    latest = Latest()
    assert latest.get() is None
    latest.put(1)
    latest.put(2)
    assert latest.get() == 2


def test_a_reader_skips_what_it_was_too_slow_for_and_gets_nothing_twice():
    async def read():
        latest = Latest()
        with latest.subscribe() as subscription:
            for value in (1, 2, 3):
                latest.put(value)
            first = await subscription.next()
            again = asyncio.create_task(subscription.next())
            await asyncio.sleep(0)
            assert not again.done()
            latest.put(4)
            return first, await again

    assert asyncio.run(read()) == (3, 4)


def test_another_thread_wakes_all_readers():
    async def read():
        latest = Latest()
        with latest.subscribe() as one, latest.subscribe() as other:
            threading.Thread(target=latest.put, args=("value",)).start()
            return await asyncio.gather(one.next(), other.next())

    assert asyncio.run(asyncio.wait_for(read(), 5)) == ["value", "value"]


def test_a_reader_that_has_left_is_forgotten():
    woken = []
    latest = Latest()

    async def read():
        with latest.subscribe() as subscription:
            subscription._waiting.set = lambda: woken.append("now")
            latest.put(1)

    asyncio.run(read())
    assert len(woken) == 1
    latest.put(2)
    assert len(woken) == 1
    assert latest.get() == 2


def test_a_slow_reader_gets_what_is_newest_when_it_is_due_and_the_last_of_all():
    async def read():
        latest = Latest()
        with latest.subscribe(rate=20.0) as subscription:
            begin, got = time.monotonic(), []
            for value in range(3):
                latest.put(value)
                got.append(await subscription.next())
            latest.put("newer")
            latest.put("last")
            got.append(await subscription.next())
            return got, time.monotonic() - begin

    got, passed = asyncio.run(asyncio.wait_for(read(), 5))
    assert got == [0, 1, 2, "last"]
    assert passed > 2 / 20
