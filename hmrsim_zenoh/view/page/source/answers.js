// What others answer is not always what was asked for.

import { isSound } from '../model/shapes.js';
import { RequestError } from './connection.js';

/** Return what came on a key, if it is as it should be. @param {string} key @param {any} payload */
export function sound(key, payload) {
  if (!isSound(key, payload)) throw new RequestError(`what is on ${key} can't be read`);
  return payload;
}

/** Say what is wrong with us; what is wrong with the simulator will be asked again. @param {Error} error */
export function complain(error) {
  if (error.name !== 'RequestError') console.error(error);
}
