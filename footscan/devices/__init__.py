"""The machine's devices: a small vocabulary, the interlock before every output, and the turning head.

| file | what |
|---|---|
| `clock` | the one time all stamps are in |
| `values`, `protocols` | what a camera, an encoder and a digital I/O module say and do |
| `interlock` | the only door to lasers and motor |
| `carriage` | the head: angle, speed, stall, wrong way, jumps |
| `rig` | all of it opened together |
"""
