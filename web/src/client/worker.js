/**
 * The worker of `Client`, with one session per model.
 * @module
 */
import { Link } from './link.js';
import { Session } from './session.js';
import { warmUp } from './warm_up.js';

/** The idle time in milliseconds before the worker warms up for the first model. */
const IDLE = 200;

/** @type {any} */
const scope = self;
const link = new Link();
/** @type {Map<number, Session>} */
const sessions = new Map();

scope.onmessage = (/** @type {MessageEvent<any>} */ { data }) => {
  const { id, type } = data;
  if (type === 'bandwidth') {
    link.bitsPerSecond = data.bitsPerSecond;
    return;
  }
  let session = sessions.get(id);
  if (type === 'load') {
    session = new Session((message, transfer) => scope.postMessage({ ...message, id }, transfer ?? []), link);
    sessions.set(id, session);
  }
  session?.receive(data);
  if (type === 'close') sessions.delete(id);
};

setTimeout(() => {
  if (sessions.size === 0) warmUp();
}, IDLE);
