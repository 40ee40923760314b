"""A client that is slow loses what is old, and never makes the server keep more."""

import asyncio

from drillrig_env.room.outbox import MOST_STEPS, Outbox


def test_only_the_newest_steps_wait_and_the_gap_is_told():
    async def go():
        outbox = Outbox()
        for step in range(MOST_STEPS):
            outbox.add(step)
        assert (await outbox.take())[1:] == (list(range(MOST_STEPS)), False)
        for step in range(1000):
            outbox.add(step)
        _, steps, gap = await outbox.take()
        assert steps == list(range(1000 - MOST_STEPS, 1000))
        assert gap
        assert outbox.left_out == 1000 - MOST_STEPS
        outbox.add(1000)
        assert (await outbox.take())[1:] == ([1000], False)

    asyncio.run(go())


def test_a_text_takes_the_place_of_one_of_its_kind_and_goes_behind_what_was_said_before():
    async def go():
        outbox = Outbox()
        outbox.say("state 1", "state")
        outbox.say("refused")
        outbox.say("refused")
        outbox.say("state 2", "state")
        assert (await outbox.take())[0] == ["refused", "refused", "state 2"]
        for number in range(1000):
            outbox.say(f"{number}")
        texts, _, _ = await outbox.take()
        assert len(texts) <= 64
        assert texts[-1] == "999"

    asyncio.run(go())


def test_steps_that_come_at_once_go_together():
    async def go():
        outbox = Outbox()
        waiting = asyncio.create_task(outbox.take())
        outbox.add(0, more=True)
        await asyncio.sleep(0.01)
        assert not waiting.done()
        outbox.add(1)
        assert await waiting == ([], [0, 1], False)

    asyncio.run(go())


def test_steps_of_a_run_that_is_over_are_forgotten():
    async def go():
        outbox = Outbox()
        outbox.add(1)
        outbox.forget_steps()
        outbox.say("state")
        assert await outbox.take() == (["state"], [], False)

    asyncio.run(go())
