import asyncio
import threading

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
