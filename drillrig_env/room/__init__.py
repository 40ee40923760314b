"""The control room: two rigs live in the browser, and hands on the force and the speed.

See docs/room.md for those who use it, and docs/room_protocol.md for what goes between server and page. The simulation
is the environment's own batch core; nothing is computed twice, and a run by hand is replayed by the environment bit
for bit (`drillrig_env.env.recorded`).
"""
