"""The numbers that decide what is said: each once, with unit, reason and both wrong sides.

A comment reads `[unit] what it decides. Why so. Smaller: what goes wrong. Larger: what goes wrong.`
The table of docs/method.md is made from these comments by `pyport dev thresholds --into`;
`make mutants-diagnosis` doubles and halves each number and runs the tests of the decisions.
Steps of grids, rounds of iterations and widths of shapes stand where they are used.
"""

from __future__ import annotations

# Evidence, in twice the logarithm of a Bayes factor (Kass & Raftery 1995, JASA 90, 773).

#: [2 ln Bayes factor] What convinces: a change beside noise estimated anew, an effect in place of
#: an earlier one, a field in place of names, an effect that is to stand. Odds of twenty to one.
#: Smaller: random walks through nights are claimed as steps. Larger: steps of half a sigma
#: between few nights go unfound.
CONVINCING = 6.0
#: [2 ln Bayes factor] How far behind the winner an effect still belongs to its class. Odds of
#: fifty to one: who reads one name of fifty must not be misled by it. Smaller: wrong names stand
#: alone. Larger: classes hold what the data exclude.
NOT_EXCLUDED = 8.0
#: [2 ln Bayes factor] By how much an effect whose known size comes out wrong must beat all others
#: to lead for now. Very strong on the scale of Kass & Raftery; the end of the search tests its
#: size again. Smaller: aberration leads where something else was left out. Larger: of two causes
#: that bend each other the one of known size is not found.
LEADS = 10.0
#: [2 ln Bayes factor] What each name beyond the first costs against a field. Twice what
#: convinces: few things are left out at once, and each name was one of many. Smaller: patchworks
#: of names stand for one unknown cause. Larger: two true causes give way to a field.
NAME_PRICE = 2 * CONVINCING
#: [2 ln Bayes factor] How far behind a rival is out of reach: tried no more beside other noise or
#: on resampled data, and of two curves alike the one that leaves so much more is excluded. No
#: noise does that: odds of ten to the thirteenth. Smaller: the right member of a family is passed
#: over because the noise holds part of it. Larger: time, and classes of curves the data
#: distinguish.
OUT_OF_REACH = 60.0

# Chances and shares.

#: [probability] How often noise alone may have a field without a name, as its odds bound it, and
#: the p-value of the whole search up to which what is left is said not to look like the noise.
#: Below the 5 % that are usual, because no noise is quite as it was fitted; `make calibrate`.
#: Smaller: what has no form in the catalogue passes for an all-clear. Larger: fields in noise,
#: and clean recordings that are said to hide something.
FAMILY_ERROR = 0.01
#: [share of the gain] What of its gain in the fit an effect must gain on data left out. Unseen
#: data gain less than seen ones, but not that much less. Smaller: what one session alone shows
#: passes. Larger: true effects of many coefficients fail.
UNSEEN_SHARE = 0.3
#: [share of the gain] What a strong effect leaves because its shape is known to first order only:
#: a further finding must gain more, and curves that differ by less are alike. Two per cent of a
#: gain are a seventh of the size. Smaller: remains of a strong effect become findings. Larger: a
#: weak second cause beside a strong one goes unfound.
IMPERFECTION = 0.02
#: [squared cosine] From which two curves beside the model are alike. A cosine of 0.95: what
#: differs is under a third of the size. Smaller: classes of curves that data could distinguish.
#: Larger: the same curve under two names is called two things.
ALIKE = 0.95**2
#: [squared cosine] From which two curves are one and the same, whatever sizes physics allows.
#: What differs is a tenth of the size. Smaller: effects of wrong known size join a class. Larger:
#: the same curve, rounded, is another.
IDENTICAL = 0.99
#: [share of the size] By which a coefficient that physics fixes may be off besides its error.
#: Shapes are known to first order only. Smaller: true refraction is refused for its size. Larger:
#: a sag passes for it.
KNOWN_SHARE = 0.1
#: [share of the length] What a candidate must keep of itself beside the model to be tested.
#: Directions, and the Sun's place, are good to a few parts in ten thousand. Smaller: what they err
#: by passes for a huge effect that the model hides. Larger: effects are not looked for of which
#: the sky shows little.
VISIBLE = 1e-3
#: [factor] To which other causes may bend a known size while the search goes on. They act alike
#: over part of the sky. Smaller: the one of known size is not found first. Larger: any size
#: leads.
BENT = 2.0
#: [share of the strength] By which strengths in two halves, or in two nights, may differ whatever
#: their sigmas. A small difference does not refute a cause. Smaller: imperfect shapes lose their
#: names. Larger: what acts in one half alone keeps a name.
SAME_STRENGTH = 0.5
#: [share of the draws] In which a name must come first on resampled data to stand alone. Below,
#: the data decide now this way, now that; a share of 0.8 of forty draws is known to 0.06.
#: Smaller: names stand that half of the nights would change. Larger: chance takes true names
#: away.
STABLE = 0.8
#: [share of the draws] From which another name that came first joins the class. Four of forty: a
#: name whose chance is one in a hundred does so once in 2,700 cases. Smaller: single draws widen
#: a class. Larger: real rivals are kept silent.
NOTICEABLE = 0.1
#: [share] What is most: draws without any name above it, and the verdict is `unknown`; what of a
#: disagreement of axes a cause may leave; what of a wandering oscillation other periods may
#: explain. A majority. Smaller: names vanish where they mostly came back. Larger: names stand
#: where there mostly was none.
MOSTLY = 0.5
#: [share of the variance] Of a column that a cubic in time draws, from which it went with the
#: hour. What else went with the hour is then alike to a cosine of 0.95. Smaller: weather of one
#: night that wandered is refused. Larger: one night's temperature curve passes for thermal
#: physics.
WITH_THE_HOUR = 0.9
#: [order] Of the polynomial in time that draws a column which went with the hour. Rise, fall and
#: turn of one night. Smaller: one night's weather passes for a cause. Larger: weather that swung
#: several times in a night is refused.
NIGHT_ORDER = 3
#: [share of the other axis] From which an axis belongs to a finding. Less is projection. Smaller:
#: sentences name both axes always. Larger: the weaker axis is not mentioned.
AXIS_SHARE = 0.2
#: [share of the variance] Of drifts and departures that weighs readings when coefficients are
#: estimated. At 1 single nights of public recordings are left with up to 1.25 times the scatter
#: of least squares in the fit and 1.12 on blocks left out, at 0.15 with 1.05 and 1.03; at 0
#: coefficients in drifts of two hours err by 1.25 times what they do at 1, at 0.15 by 1.07.
#: Smaller: coefficients err more where drifts are real. Larger: fits follow differences between
#: neighbours.
TRUST = 0.15
#: [robust weight] Below which a reading is left out of every rms. Student's t with four degrees
#: of freedom gives it at 8.7 sigma. Smaller: outliers make the rms. Larger: heavy tails are
#: hidden.
OUTLIER_WEIGHT = 0.05

# Sigmas and scatters.

#: [sigma] From which a difference counts: axes coupled, halves or nights different, an antenna's
#: part, a slope, a cause of a disagreement for each coefficient. Chance gives it once in 370.
#: Smaller: chance is reported. Larger: what is there is not.
SIGNIFICANT = 3.0
#: [sigma] From which a strength in one half, or the size that physics fixes, refutes a name. One
#: step beyond what counts, for each name is put to several such tests. Smaller: true names are
#: refused. Larger: wrong names stand.
REFUTES = 4.0
#: [sigma] From which something is seen at all, and below which halves agree: a curve in a night,
#: a known size against its error. Chance gives it once in 22. Smaller: nights that saw nothing
#: count. Larger: nights that saw it do not.
SEEN = 2.0
#: [sigma] By which a finding must lower the rms of data left out, where three blocks, or FEWEST
#: whole sessions, tell the error. A fall within its error shows nothing. Smaller: a seventh of the
#: claims where nothing is hidden stays. Larger: at 2 one right finding in fourteen is lost.
PAYS = 1.0
#: [sigma] Where the biweight of the first look reaches zero, antennas of arrays alike. Normal
#: readings keep their weight; the tails are estimated afterwards. Smaller: tails are cut before
#: they are looked at. Larger: one bad reading bends the first look.
FIRST_REACH = 6.0
#: [scale of the others] Least scatter of gross errors in a mixture. Closer ones cannot be
#: distinguished from the bulk. Smaller: two normals split the bulk between them. Larger: outliers
#: of five sigma have no mixture.
LEAST_GROSS = 3.0
#: [share] Of the readings that may be gross errors. Where more seem so, few readings lie on the fit
#: and the rest about it: Student's t has such tails. Smaller: a bad night of four is none. Larger:
#: 14 of 24 readings that a fit goes through pass for sound ones, and all else for gross errors.
MOST_GROSS = 1 / 3
#: [usual scatter] Beyond which a reading left out, missed by both fits, is a gross error, and an
#: antenna counts in no rms. No prediction can be judged by either. Smaller: heavy tails are not
#: counted. Larger: one gross error decides what predicts better.
GROSS = 10.0
#: [whitened square] Most that one prediction counts in the search. Five sigma: a coefficient may
#: rest on one scan. Smaller: what improves bad predictions earns nothing. Larger: one reading
#: decides.
CLIP = 25.0
#: [median error] Beyond which an antenna is no reference and compared with nothing. It would add
#: its error only. Smaller: good antennas are lost. Larger: one bad antenna moves all others.
WORSE = 3.0
#: [2 ln restricted likelihood] What a variance of departures must earn to be kept. Of zero
#: variances one lets 16 % through, which costs precision but no validity. Smaller: precision is
#: lost in half of all recordings. Larger: nights that differ become findings.
DEPARTURE_WORTH = 1.0

# Oscillations.

#: [s] Shortest period of an oscillation. The worm of an equatorial drive turns once in four to ten
#: minutes, servos and air conditioners are slower. Smaller: what happens within a few pointings is
#: claimed as periodic. Larger: worms go unfound.
SHORTEST_PERIOD_S = 200.0
#: [median steps between readings] Shortest period where readings are rare. Two show a wave at
#: all, and a third shows that it is one. Smaller: what alternates from one reading to the next is
#: a period. Larger: periods go unfound where readings are rare.
SHORTEST_STEPS = 3.0
#: [periods] That a session must hold by itself: a single one, or each where the phase wanders. One
#: is a drift, and nothing came back. Smaller: the drift of a night is an oscillation. Larger: slow
#: oscillations of one long night go unfound.
PERIODS_ALONE = 2.0
#: [periods] In which a wandering phase is one. That of quality factor 10 is forgotten, by e, in
#: 10 / pi of them. Smaller: each stretch fits its noise, so that nothing is worth it. Larger: the
#: phase turns within a stretch, and the wave is lost.
PERIODS_FREE = 3.0
#: [share of the period] From which a wandering period is another one to choose among. The width
#: of a line of quality factor 10. Smaller: oscillations pay for choices that are none. Larger:
#: the best of many periods is taken for one that was tried alone.
ANOTHER_PERIOD = 0.1

# Too few: one rule, three counts. Of less than FEWEST readings nothing is estimated, placed or
# shaped; a scale that is to weigh something is known from ENOUGH numbers, squares that are to show
# what they follow from ENOUGH_SQUARES.

#: [readings] Fewer give no tails, no place of a step or an edge, no stretch, bump or cell, no
#: scatter to compute a limit from. Of eight the scatter falls below a quarter of the truth in
#: 0.01 % of all cases, of four in 0.7 %. Smaller: a handful of outliers is a shape. Larger: steps
#: in the last hour are not placed.
FEWEST = 8
#: [numbers beyond the coefficients] Fewer, and nothing is looked for, no finding keeps a name, no
#: drift is estimated. The scatter is known to 1 / sqrt(2 n): from twenty to a sixth, so that four
#: sigmas may be three and a half or five. Smaller: chance that the scatter is small makes
#: findings. Larger: short sessions that could be diagnosed are refused.
ENOUGH = 20
#: [deviations] Fewer, and the variance follows nothing and both axes are independent. A square
#: scatters by 1.4 times itself, so that forty know a variance to a fifth. Smaller: weights follow
#: chance. Larger: small sets keep uneven scatter as claims.
ENOUGH_SQUARES = 40
#: [effective pointings] Fewer that carry an effect, and it has no name; a night has as many.
#: Three could be one place pointed at again. Smaller: a handful of readings is physics. Larger:
#: what acts in a corner of the sky is never named.
CARRIERS = 4
#: [labels] Fewer sessions, sources or antennas say nothing of what they do to each other: no
#: departures, no session left out whole, no array. Of two neither is the odd one out. Smaller:
#: half of the data are left out. Larger: three nights are treated as one.
SEVERAL = 3
#: [antennas] Fewer show no common mode, no usual noise, no slope over places. Of three the mean
#: and the median are one antenna's. Smaller: one antenna speaks for the array. Larger: small
#: arrays have none.
ENOUGH_ANTENNAS = 4
#: [pointings per direction] Or scans: what is left of each direction that is projected out before
#: noise is read off; readings for each coefficient of an effect that every antenna or session has
#: its own of. Three of four deviations are left. Smaller: the search takes the noise away. Larger:
#: candidates are noise.
PER_SHAPE = 4
#: [pointings per label] Average below which sources have no departures, and rows below which
#: sessions are no sessions. One departs only if it was pointed at again. Smaller: single pointings
#: are taken for departures. Larger: catalogues with errors become findings.
PER_LABEL = 2.0
#: [deviations] Weight of the array's usual variance in that of an antenna. A scale from few
#: deviations may be small by chance. Smaller: one that is quiet by chance outvotes all. Larger:
#: quiet antennas are not believed.
PRIOR_DOF = 6.0

# How many.

#: [findings] At most; a warning says when the search stopped there. Few things are left out at
#: once. Smaller: searches end early. Larger: time, where a misfit is no sum of effects.
MOST_FINDINGS = 8
#: [candidates] Of a turn that may fail on data left out, or are confirmed beside a change, each a
#: curve of its own. The fifth best is no candidate. Smaller: the right one is not reached. Larger:
#: time.
MOST_TRIED = 4
#: [effects] In a class; a larger one says nothing and is `unknown`. Seven names are no name.
#: Smaller: classes that say something are not reported. Larger: lists without meaning.
MOST_MEMBERS = 6
#: [folds] Of whole sessions, at most. More cost time and change little. Smaller: sessions are
#: predicted from fewer others. Larger: time.
MOST_FOLDS = 20
#: [folds] Of scans or pointings. Nine tenths of the data are left to fit. Smaller: the fit
#: without a fold is another fit. Larger: time.
FOLDS = 10
#: [blocks of time] In each session that is not left out whole. Longer than most drifts, short
#: enough to be predicted. Smaller: a fifth of the sky is predicted from the rest. Larger: drifts
#: predict their neighbours.
BLOCKS = 5
#: [sessions] From which whole ones are resampled. Fewer have too few different draws. Smaller:
#: names fall with single nights. Larger: nights that differ are cut to pieces that agree.
ENOUGH_TO_RESAMPLE = 10
