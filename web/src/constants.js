/**
 * Constants of the format. Encoder and decoder must agree on all of them.
 * @module
 */

/** The denominator of probabilities. */
export const WHOLE = 1 << 16;
/** The minimum range of the coder. */
export const MIN_RANGE = 1 << 24;
/** The maximum number of trailing zero bytes that are omitted from a payload. */
export const MAX_TRIMMED = 4;

/** The maximum count of a slot. */
export const MAX_COUNT = 255;

/** The number of tabulated exponentials of scores, from e⁰ to e⁻⁸. */
export const FALLS_LENGTH = 256;
/** The learning rate of scores: an error is divided by two to this power. */
export const SCORE_RATE = 4;

/** The number of levels with their own symbols, from −2 on in quarters of an octave. */
export const LEVELS = 80;
/** The symbol of the expected bucket, and the last symbol. */
export const MIDDLE_SYMBOL = 9;
export const LAST_SYMBOL = 15;
/** The highest bucket. */
export const MAX_BUCKET = 59;
/** The number of contexts of small numbers, and the maximum bits of a small number. */
export const SMALL_CONTEXTS = 32;
export const MAX_SMALL_BITS = 25;

/** Fans with more corners are not split. */
export const MAX_CORNERS = 1024;
/** The maximum number of fans of a point to choose from. */
export const MAX_TWINS = 1024;
/** The features of a split flag: valence and free corners; age; distance from the mean. */
export const AGE_FEATURES = 16 * 8 * 4;
export const DISTANCE_FEATURES = AGE_FEATURES + 8;
export const MARK_FEATURES = DISTANCE_FEATURES + 32;
/**
 * The roles of an edge, its length classes, and the valence classes at its other end; the first of
 * these means border.
 */
export const ROLES = 3;
export const LENGTHS = 16;
export const VALENCES = 16;
/** Fans with more corners use no scored choices. */
export const MAX_CHOICES = 15;

/** The number of estimates in addition to the mean of the polygon. */
export const ESTIMATES = 4;
/** The maximum absolute Laplacian. */
export const MAX_LAPLACIAN = 1 << 21;
/** The point counts with their own weights: 3, 4, 5, 6, 7, and more. */
export const POLYGONS = 6;
/**
 * The classes of batches with their own weights: the last, the second to last, and all earlier
 * ones.
 */
export const REGIMES = 3;
/** The fixed-point value of weight 1. */
export const WEIGHT_ONE = 64;
/** The default weights of the estimates, along the normal and perpendicular to it. */
export const USUAL_WEIGHTS = [42, 13, -6, -12, 12, 14, 32, 52];
/**
 * The initial weights of the level features: perpendicular to the normal, along it, and of
 * attributes.
 */
export const BESIDE_LEVEL = [55000, 40000, 29000, 42000, 13000];
export const ALONG_LEVEL = [36000, 6000, 6000, 9000, 3000];
export const CHANNEL_LEVEL = [-8000, 50000, 10000];
/** The squared side length assumed for unknown triangles. */
export const USUAL_SQUARE = 1 << 24;

/** The number of components with their own contexts. */
export const MAX_AXES = 4;

/** Limits of the base header. */
export const MAX_BITS = 16;
export const MAX_CHANNELS = 64;
export const MAX_NAME_BYTES = 256;
export const MAX_CHANNEL_BITS = 24;
/** The maximum size of a chunk header including its checksum, in bytes. */
export const MAX_HEAD_BYTES = 5 * 5 + 4 + 4;
