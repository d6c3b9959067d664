"""Is the formula that I found right?

A condition from a paper or a web page is compared with the singular set itself: exact, too small, or too large, and a
configuration that shows it.
"""

import rankdrop

found = rankdrop.conditions(rankdrop.open_robot("puma560"), coranks=1)  # a2, a3, d3, d4 are its lengths

for text in (
    "s5 (d4 c3 + a3 s3) (a2 c2 + a3 c23 − d4 s23)",  # shoulder, elbow and wrist
    "s5 s3",  # "elbow straight where θ3 = 0": not with an offset a3
    "sin(q5)",  # the wrist alone
):
    result = found.test(text)
    print(f"{text}: {result.verdict}")
    for sentence in result.sentences():
        print("   ", sentence)
