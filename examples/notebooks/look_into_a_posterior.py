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
# A belief is the end of a chain of latents: how the sentence was meant, which place each name
# refers to, which way a building faces, whether a phrase was a slip. All of them stay in the
# posterior. This tutorial asks for each of them, asks the speaker back, and ends with one sheet
# that explains the belief.

# %%
import matplotlib.pyplot as plt  # with it, notebooks show figures

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
# "A bar" may be one of several. Each candidate has a probability; None is a place that is not
# on the map.

# %%
for ground in posterior.grounds(target):
    candidates = ", ".join(f"{c.ground} {c.p:.2f}" for c in ground.candidates)
    print(f"{ground.relation.relation:7s} {candidates}")

# %% [markdown]
# ## Which phrase tells most?
#
# `influence` infers again without each phrase, and measures how far the belief moves, in bits.

# %%
for influence in posterior.influence(target):
    print(f"{influence.relation.relation:7s} {influence.bits:.2f} bits")

# %% [markdown]
# ## Was a phrase a slip?
#
# Every phrase has a latent that says it was not meant, the lapse.

# %%
for lapse in posterior.lapses(target):
    print(f"{lapse.relation.relation:7s} {lapse.prior:.2f} -> {lapse.p:.2f}")

# %% [markdown]
# ## Which way does Velvet Dog face?
#
# "Behind" needs the front of its ground. The frame of reference is a distribution over
# directions, before (the prior, from the map) and after. The belief carries both, so that a wrong
# guess is not final.

# %%
front = posterior.frame(target, relation=0)
ax = sloop.plots.plot_frame(city, "VelvetDog", front.values, prior=front["prior"].values)

# %% [markdown]
# ## What should one ask?
#
# `ask` finds the questions with the largest expected information. An answer is evidence like a
# sentence.

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
# Next: [all that a posterior can be asked](../posterior.md), and [what questions are
# worth](../asking.md).
