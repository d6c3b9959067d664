"""KG's matrices and equations as printed, where the damaged copy needed it restored; read by `formula`.

Rows of matrices are KG's, (ω; v). The copy at hand is OCR: "deg"-like tokens stand for d c4, d c34, d c45 or d c5,
"2 ce" for 2 c c, and so on; every reading was tried against the arm.
"""

LENGTHS = {"a": 0.635, "c": 0.504, "d": 6.85}
"""Typical lengths of Canadarm2 [m]; KG have letters only."""
DH = [("0", "0", "0"), ("0", "pi/2", "a"), ("0", "-pi/2", "c"), ("d", "0", "0"), ("d", "0", "c"), ("0", "pi/2", "a"),
      ("0", "-pi/2", "0")]  # fmt: skip
"""Figure 1(b): rows (a_{j−1}, α_{j−1}, d_j), modified DH."""
EQ_5_FIRST = """s2 c345
-s2 s345
c2
(d s45 + a c345 + d s5) c2 - 2 c s2 s345
-(-d c45 + a s345 - d c5) c2 - 2 c s2 c345
-s2 (-d s3 + a - d s34)"""
EQ_6 = """-s345 | 0 | 0 | 0 | 0 | -s6
-c345 | 0 | 0 | 0 | -1 | 0
0 | 1 | 1 | 1 | 0 | c6
-2 c c345 | d s5 + d s45 | d s5 | 0 | 0 | -a c6
2 c s345 | d c5 + d c45 | d c5 | 0 | 0 | 0
d c34 + d c3 | 0 | 0 | 0 | 0 | -a s6"""
EQ_7 = "d^2 s4 s6 (a s345 + d c34 + d c3)"
EQ_11 = """-s35 c4 | 0 | 0 | 0 | 0 | -s6
-c35 c4 | 0 | 0 | 0 | -1 | 0
0 | 1 | 1 | 1 | 0 | c6
-2 c c35 c4 | d s5 + d c4 s5 | d s5 | 0 | 0 | -a c6
2 c s35 c4 | d c5 + d c4 c5 | d c5 | 0 | 0 | 0
d c3 c4 + d c3 | 0 | 0 | 0 | 0 | -a s6"""
EQ_12_FIRST = """s2 c35 c4
-s2 s35 c4
c2
c2 d c4 s5 + c2 a c35 c4 + c2 d s5 - 2 c s2 s35 c4
c2 d c4 c5 - c2 a s35 c4 + c2 d c5 - 2 c s2 c35 c4
-s2 (-d s3 + a - d s3 c4)"""
EQ_15 = (
    "(-c2 s6 a c3 + 2 c s2 s3 s6 + s2 c35 a c5 c6)(a s35 c4 + d c3 c4 + d c3)"
    " + s2 (-a c35 c4 + d s3 c4 + d s3 - a)(-2 c c3 s6 + a s35 c5 c6)"
)
EQ_16_LAST = """0
0
c6
-a c6
0
0"""
EQ_19 = "-d^2 s2 s4 (a s345 - d c45 - d c5)"
EQ_20 = "a s345 - d c45 - d c5"
EQ_22 = "-d^2 s4 s6"
EQ_25 = "s2 d^2 s4 s6 (-a c345 + d s3 - a + d s34)"
EQ_10 = "a s345 + d c34 + d c3"
EQ_26 = "-a c345 + d s3 - a + d s34"
FAMILIES = {
    15: (("s4", EQ_15), ()),
    20: (("s6", EQ_20), ("s4",)),
    21: (("s6", "s2"), ("s4",)),
    26: ((EQ_10, EQ_26), ("s4", "s6")),
    27: ((EQ_10, "s2"), ("s4", "s6")),
}
"""Equation number -> what vanishes, and what does not."""
