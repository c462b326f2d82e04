/** What to tell a person when asking the hub for something failed. */

export interface Advice {
  readonly what: string;
  readonly how: string;
}

/** The part of a refusal that this needs; see `wire/http.ts`. */
interface Said {
  readonly status: number;
  readonly retryAfter: number;
  readonly message: string;
}

const UNREACHABLE: Advice = {
  what: "The hub cannot be reached.",
  how: "Check the network between this device and the hub, and that the hub is running. It is safe to try again.",
};

/** @param asked what was asked for, as the object of a sentence: `the list of sites` */
export function adviceFor(error: unknown, asked: string): Advice {
  if (!isRefusal(error)) return UNREACHABLE;
  if (error.status === 403) {
    return { what: `You may not see ${asked}.`, how: "An admin of this hub can give you the right." };
  }
  if (error.status === 404) {
    return { what: `There is no such thing here: ${asked}.`, how: "It may have been renamed or removed." };
  }
  return { what: `The hub could not give ${asked}.`, how: error.message };
}

/** Advice for a sign-in that failed. */
export function signInAdvice(error: unknown): Advice {
  if (!isRefusal(error)) return UNREACHABLE;
  if (error.status === 429) {
    const wait = error.retryAfter > 0 ? `in ${String(Math.ceil(error.retryAfter))} seconds` : "in a little while";
    return { what: "Too many tries.", how: `The hub slows down whoever guesses. Try again ${wait}.` };
  }
  if (error.status === 401 || error.status === 403) {
    return { what: "Name or password is wrong.", how: "Check both; capital letters count." };
  }
  return { what: "The hub did not let you in.", how: error.message };
}

function isRefusal(error: unknown): error is Said {
  return error instanceof Error && "status" in error && "retryAfter" in error;
}
