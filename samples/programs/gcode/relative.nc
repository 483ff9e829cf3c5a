; G91: what one word takes on, the next ones give back
G21 G90
G0 X100 Y100 Z-5
G91
G1 X50 F800
X-20
Y30
X10 Y-10
G90
X100 Y100
G91 G28 Z0
M30
