"""Of a listening server: what it sends is on its way at once."""

import asyncio
import errno
import os
import socket

import pytest

from app.page.listening import listen


async def delay_is_off(listening: socket.socket) -> bool:
    """As asyncio leaves the connections that it accepts."""
    answered = asyncio.get_running_loop().create_future()
    server = await asyncio.start_server(
        lambda reader, writer: answered.set_result(writer), sock=listening
    )
    async with server:
        _, client = await asyncio.open_connection(*listening.getsockname()[:2])
        writer = await answered
        off = writer.get_extra_info("socket").getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)
        for one in (writer, client):
            one.close()
            await one.wait_closed()
    return bool(off)


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "0.0.0.0"])
def test_no_part_of_an_answer_waits_until_the_one_before_is_acknowledged(host):
    assert asyncio.run(delay_is_off(listen(host, 0)))


def test_a_descriptor_that_another_thread_took_is_not_closed_in_its_hands(monkeypatch):
    """It takes the spare one, which is closed to drop a connection; then none is left."""

    def used_up(*_: object) -> None:
        raise OSError(errno.EMFILE, "too many open files")

    def accept(_: socket.socket) -> None:
        try:
            os.fstat(spare)
        except OSError:
            os.dup2(0, spare)
        used_up()

    with listen("127.0.0.1", 0) as listening, monkeypatch.context() as scarce:
        spare = listening._spare
        scarce.setattr(os, "open", used_up)
        scarce.setattr(socket.socket, "accept", accept)
        for _ in range(2):
            with pytest.raises(BlockingIOError):
                listening.accept()
        ours = os.fstat(0)
        assert os.path.samestat(os.fstat(spare), ours)
    assert os.path.samestat(os.fstat(spare), ours)
    os.close(spare)
