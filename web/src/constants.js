/**
 * The numbers that the format fixes. An encoder and a decoder that differ in one of them do not understand each other.
 * @module
 */

/** The number of which probabilities are shares. */
export const WHOLE = 1 << 16;
/** The range of the coder is at least this. */
export const LEAST_RANGE = 1 << 24;
/** Zeros at the end of a payload that are left out, at most. */
export const MOST_TRIMMED = 4;

/** The shares of `WHOLE` that belong to the logits 0, 1/4, 1/2, … 8. */
export const SHARES = [
  32768, 36843, 40793, 44511, 47911, 50941, 53581, 55834, 57724, 59287, 60565, 61598, 62428, 63090, 63615, 64030, 64357,
  64614, 64816, 64974, 65097, 65194, 65269, 65328, 65374, 65410, 65438, 65459, 65476, 65489, 65500, 65508, 65514,
];
/** The largest logit, in units of 1/256. */
export const MOST_LOGIT = 2047;
/** A slot counts up to this. */
export const MOST_COUNT = 250;
/** The largest weight, in units of 2⁻¹⁴. */
export const MOST_WEIGHT = (1 << 17) - 1;
/** The contexts of each decision. */
export const INPUTS = 6;
/** The weight of each input at first: 1.3 / `INPUTS`. */
export const FIRST_WEIGHT = Math.floor((13 << 14) / (10 * INPUTS));
/** A probability that is not mixed is at least this, and as much less than `WHOLE`. */
export const LEAST_SHARE = 32;

/** The scales of numbers. */
export const SCALES = 96;
/** The steps away from the usual bucket that have contexts of their own; the first goes down or up from it. */
export const STEPS = 32;
export const FIRST_STEP = 16;
/** The largest bucket. */
export const MOST_BUCKET = 59;
/** The contexts of small numbers, and the bits of the largest one. */
export const SMALL_CONTEXTS = 32;
export const MOST_SMALL_BITS = 25;

/** A fan of more corners is not split. */
export const MOST_CORNERS = 1024;
/** The fans of a point among which one is chosen. */
export const MOST_TWINS = 1024;
/** The slots of each input of a decision about splits. */
export const SPLIT_SLOTS = 4096;
/** The sets of weights of such a decision. */
export const SPLIT_SETS = 8;

/** The estimates beside the mean of the polygon. */
export const ESTIMATES = 5;
/** The numbers of points that have weights of their own: 3, 4, 5, 6, 7, and more. */
export const POLYGONS = 6;
/** The batches that have weights of their own: the last, the last but one, and all before. */
export const REGIMES = 3;
/** The weight one. */
export const WEIGHT_ONE = 32;
/** The usual weights of each estimate along the normal and beside it. */
export const USUAL_WEIGHTS = [22, 7, -3, -10, -2, -1, 8, 6, 0, 0];
/** The contexts of a coordinate. */
export const PLACE_CONTEXTS = 1024;
/** The most that counts as a surprise. */
export const MOST_SURPRISE = 10;
/** The square length of the sides of triangles that are not known. */
export const USUAL_SQUARE = 1 << 24;

/** The contexts of a component of an attribute. */
export const CHANNEL_CONTEXTS = 64;
/** The components that have contexts of their own. */
export const MOST_AXES = 4;

/** What a head may say. */
export const MOST_BITS = 16;
export const MOST_CHANNELS = 64;
export const MOST_NAME_BYTES = 256;
export const MOST_CHANNEL_BITS = 24;
/** The most bytes of the head of a chunk, with its checksum. */
export const MOST_HEAD_BYTES = 5 * 5 + 4 + 4;
