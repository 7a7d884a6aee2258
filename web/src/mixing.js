/**
 * Probabilities of decisions, learned while decoding: several contexts each have an opinion, and weights that are learned too mix them.
 *
 * ```text
 * context 0 ─▶ probability ─▶ logit ─ × weight 0 ─┐
 * context 1 ─▶ probability ─▶ logit ─ × weight 1 ─┼─▶ sum ─▶ probability ─▶ range decoder
 * …                                               ┘
 * ```
 * A slot is a probability of 22 bits, less one half, above a count of 10 bits: so new slots are zeros, and memory that is not used is not touched.
 *
 * Based on: Mahoney, "Adaptive Weighing of Context Models for Lossless Data Compression", 2005.
 * @module
 */
import { FIRST_WEIGHT, INPUTS, LEAST_SHARE, MOST_COUNT, MOST_LOGIT, MOST_WEIGHT, SHARES, WHOLE } from './constants.js';

/** @import { RangeDecoder } from './range_coder.js' */

/** The probability of each logit, from −`MOST_LOGIT` on. */
const SHARE_OF = Int32Array.from({ length: 2 * MOST_LOGIT + 1 }, (_, i) => {
  const logit = i - MOST_LOGIT;
  const size = Math.abs(logit);
  const at = size >> 6;
  const share = SHARES[at] + (((SHARES[Math.min(at + 1, 32)] - SHARES[at]) * (size & 63)) >> 6);
  return logit < 0 ? WHOLE - share : share;
});

/** The logit of each probability of 12 bits. */
const LOGITS = new Int16Array(4096);
for (let share = 0, logit = -MOST_LOGIT; share < 4096; share++) {
  while (logit < MOST_LOGIT && SHARE_OF[logit + MOST_LOGIT] < (share << 4) + 8) logit++;
  LOGITS[share] = logit;
}

/** 2¹⁵ / (count + 1.5). */
const RATES = Int32Array.from({ length: MOST_COUNT + 1 }, (_, count) => Math.floor(65536 / (2 * count + 3)));

/**
 * Returns the share of a slot after a decision that was always the same.
 * @param {number} bit
 */
function targetOf(bit) {
  return (-bit & ((1 << 22) - 1)) - (1 << 21);
}

/**
 * @param {number} slot
 * @param {number} target
 */
function learned(slot, target) {
  const share = slot >> 10;
  const count = slot & 1023;
  const change = Math.imul((target - share) >> 6, RATES[count]) >> 9;
  // One more, up to the limit.
  return ((share + change) << 10) | (count + ((count - MOST_COUNT) >>> 31));
}

/**
 * @param {number} weight
 * @param {number} error
 * @param {number} logit
 */
function adjusted(weight, error, logit) {
  const sum = weight + (((Math.imul(error, logit) >> 4) * 2 + (1 << 13)) >> 14);
  return sum > MOST_WEIGHT ? MOST_WEIGHT : sum < -MOST_WEIGHT ? -MOST_WEIGHT : sum;
}

/** The model of one kind of decision. */
export class Mixed {
  #first;
  #others;
  #slots;
  #weights;

  /**
   * Creates the slots of each input, and sets of weights.
   * @param {number} first the slots of the first input
   * @param {number} others those of each other one
   * @param {number} sets
   */
  constructor(first, others, sets) {
    this.#first = first;
    this.#others = others;
    this.#slots = new Int32Array(first + (INPUTS - 1) * others);
    this.#weights = new Int32Array(INPUTS * sets).fill(FIRST_WEIGHT);
  }

  /**
   * Decodes a decision in its contexts, each less than the number of slots of its input, with a set of weights.
   * @param {RangeDecoder} coder
   * @param {number} a @param {number} b @param {number} c @param {number} d @param {number} e @param {number} f
   * @param {number} set
   * @returns {number} 1 or 0
   */
  decode(coder, a, b, c, d, e, f, set) {
    const slots = this.#slots;
    const weights = this.#weights;
    const others = this.#others;
    b += this.#first;
    c += this.#first + others;
    d += this.#first + 2 * others;
    e += this.#first + 3 * others;
    f += this.#first + 4 * others;
    set *= INPUTS;
    const slotA = slots[a];
    const slotB = slots[b];
    const slotC = slots[c];
    const slotD = slots[d];
    const slotE = slots[e];
    const slotF = slots[f];
    const logitA = LOGITS[(slotA >> 20) + 2048];
    const logitB = LOGITS[(slotB >> 20) + 2048];
    const logitC = LOGITS[(slotC >> 20) + 2048];
    const logitD = LOGITS[(slotD >> 20) + 2048];
    const logitE = LOGITS[(slotE >> 20) + 2048];
    const logitF = LOGITS[(slotF >> 20) + 2048];
    const weightA = weights[set];
    const weightB = weights[set + 1];
    const weightC = weights[set + 2];
    const weightD = weights[set + 3];
    const weightE = weights[set + 4];
    const weightF = weights[set + 5];
    const sum =
      ((Math.imul(logitA, weightA) >> 7) +
        (Math.imul(logitB, weightB) >> 7) +
        (Math.imul(logitC, weightC) >> 7) +
        (Math.imul(logitD, weightD) >> 7) +
        (Math.imul(logitE, weightE) >> 7) +
        (Math.imul(logitF, weightF) >> 7)) >>
      7;
    const logit = sum > MOST_LOGIT ? MOST_LOGIT : sum < -MOST_LOGIT ? -MOST_LOGIT : sum;
    const share = SHARE_OF[logit + MOST_LOGIT];
    const bit = coder.decode(share);
    const error = (bit << 16) - share;
    const target = targetOf(bit);
    weights[set] = adjusted(weightA, error, logitA);
    weights[set + 1] = adjusted(weightB, error, logitB);
    weights[set + 2] = adjusted(weightC, error, logitC);
    weights[set + 3] = adjusted(weightD, error, logitD);
    weights[set + 4] = adjusted(weightE, error, logitE);
    weights[set + 5] = adjusted(weightF, error, logitF);
    slots[a] = learned(slotA, target);
    slots[b] = learned(slotB, target);
    slots[c] = learned(slotC, target);
    slots[d] = learned(slotD, target);
    slots[e] = learned(slotE, target);
    slots[f] = learned(slotF, target);
    return bit;
  }
}

/** A decision with a probability in each of some contexts, without mixing. */
export class Simple {
  #slots;

  /** @param {number} size the contexts */
  constructor(size) {
    this.#slots = new Int32Array(size);
  }

  /**
   * Decodes a decision in a context: 1 or 0.
   * @param {RangeDecoder} coder
   * @param {number} context
   * @returns {number}
   */
  decode(coder, context) {
    const slot = this.#slots[context];
    const share = (slot >> 16) + (WHOLE >> 1);
    const bit = coder.decode(share < LEAST_SHARE ? LEAST_SHARE : share > WHOLE - LEAST_SHARE ? WHOLE - LEAST_SHARE : share);
    this.#slots[context] = learned(slot, targetOf(bit));
    return bit;
  }
}
