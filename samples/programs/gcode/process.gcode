; a pragma leaves a stretch as it is, a process can be left out on request
G21 G90
G0 X10.0 Y10.0 Z-5.0
G1 X60.0 F600
; lostmotion: off
G1 X20.0
; lostmotion: on
M3 S100
G1 X80.0
G1 X30.0
M5
G1 X60.0 M8
G93 X20.0 F12.0
G94 G1 X50.0 F600
