/**
 * The worker of `Client`: it has a session for each model.
 * @module
 */
import { Link } from './link.js';
import { Session } from './session.js';

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
