# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Look into a posterior
#
# A belief depends on several latents: the reading of the sentence, the place to which each name
# refers, the direction that a building faces, and whether a phrase is wrong. The posterior keeps
# all of them. This tutorial looks at each, asks the speaker a question, and ends with one sheet
# that explains the belief.

# %%
import matplotlib.pyplot as plt  # so that notebooks show figures

import sloop_ppl as sloop

city = sloop.load_map("cleveland")
said = sloop.parse(
    "The green Toyota is behind Velvet Dog, near a bar and west of Hoyt Block.", city
)
posterior = sloop.infer(said, city)
target = "GreenToyota"
print(posterior.texts)

# %% [markdown]
# ## Where is it?

# %%
print("most probable:", posterior.mode(target))
print(f"entropy: {posterior.entropy(target):.2f} nats")
print("cells that hold 90 %:", int(posterior.hpd(target, 0.9).sum()))

# %% [markdown]
# ## Which place was meant?
#
# "A bar" may be one of several bars. Each candidate has a probability; None is a place that is
# not on the map.

# %%
for ground in posterior.grounds(target):
    candidates = ", ".join(f"{c.ground} {c.p:.2f}" for c in ground.candidates)
    print(f"{ground.relation.relation:7s} {candidates}")

# %% [markdown]
# ## Which phrase is most informative?
#
# `influence` repeats inference without each phrase, and measures the change of the belief in bits.

# %%
for influence in posterior.influence(target):
    print(f"{influence.relation.relation:7s} {influence.bits:.2f} bits")

# %% [markdown]
# ## Is a phrase wrong?
#
# Every phrase has a latent, the lapse, that says it is uninformative.

# %%
for lapse in posterior.lapses(target):
    print(f"{lapse.relation.relation:7s} {lapse.prior:.2f} -> {lapse.p:.2f}")

# %% [markdown]
# ## Which way does Velvet Dog face?
#
# "Behind" needs the front of its ground. The frame of reference is a distribution over
# directions. Its prior comes from the map; the sentence updates it. The belief sums over all
# directions, so that a wrong prediction is not final.

# %%
front = posterior.frame(target, relation=0)
ax = sloop.plots.plot_frame(city, "VelvetDog", front.values, prior=front["prior"].values)

# %% [markdown]
# ## Which question helps most?
#
# `ask` finds the questions with the largest expected information. An answer is evidence, as a
# sentence is.

# %%
questions = sloop.ask(posterior, city, n=2)
for question in questions:
    print(f"{question.bits:.2f} bits: {question.text}")
    for answer in question.answers:
        print(f"    {answer.p:.2f} {answer.text}")

# %%
likely = max(questions[0].answers, key=lambda answer: answer.p)
answered = posterior.update(questions[0].answer(likely.text))
print(f"{posterior.entropy(target):.2f} nats before, {answered.entropy(target):.2f} after")

# %% [markdown]
# ## One sheet

# %%
figure = sloop.bridge.figure_of(answered)
figure

# %% [markdown]
# Next: [everything that a posterior can answer](../posterior.md), and [the value of
# questions](../asking.md).
