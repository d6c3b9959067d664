"""Is the formula that I found right?

A condition from a paper or a web page is compared with the singular set itself: exact, too small, or too large, and a
configuration that shows it. Needs `pip install "rankdrop[exact]"`.
"""

import rankdrop
from rankdrop.exact.algebra.variety import independent
from rankdrop.exact.algebra.work import Work
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.reading.lint import lint
from rankdrop.exact.tree import rank_tree

chain = exact_chain(rankdrop.open_robot("puma560"))  # a2, a3, d3, d4 are its lengths
pieces = independent([drop.piece for drop in rank_tree(chain, Work()).drops])

for text in (
    "s5 (d4 c3 + a3 s3) (a2 c2 + a3 c23 − d4 s23)",  # shoulder, elbow and wrist
    "s5 s3",  # "elbow straight where θ3 = 0": not with an offset a3
    "sin(q5)",  # the wrist alone
):
    result = lint(text, pieces, chain)
    print(f"{text}: {result.verdict}")
    for sentence in result.sentences():
        print("   ", sentence)
