/** Who is signed in. */

import type { Me } from "../generated/api.js";
import type { HubApi } from "../wire/hub-api.js";
import { usePasskey } from "../wire/passkeys.js";
import { Store } from "./store.js";

/**
 * - `unknown`: not asked yet
 * - `nobody`: the hub knows nobody here
 * - `known`: `person` says who
 */
export type SessionState = "unknown" | "nobody" | "known";

const NOTE = "talaia.signed-in";

export class Session extends Store {
  private someone: Me | null = null;
  private asked = false;
  private going = false;

  /** @param notes - where this browser remembers that somebody signed in; null when it may not */
  constructor(
    private readonly api: HubApi,
    private readonly notes: Pick<Storage, "getItem" | "setItem" | "removeItem"> | null = null,
  ) {
    super();
  }

  /**
   * Whether somebody may be signed in. The cookie itself cannot be seen from here: who opens the
   * sign-in page without ever having signed in need not be asked about.
   */
  get mayExist(): boolean {
    return this.notes === null || this.notes.getItem(NOTE) !== null;
  }

  get state(): SessionState {
    if (!this.asked) return "unknown";
    return this.someone === null ? "nobody" : "known";
  }

  get person(): Me | null {
    return this.someone;
  }

  /** The hub is being told that the person goes. */
  get isSigningOut(): boolean {
    return this.going;
  }

  /** Why the last session ended, for the sign-in page; empty when nobody needs to be told. */
  notice = "";

  /** Nobody can be signed in here: known without asking the hub. */
  assumeNobody(): void {
    this.setPerson(null);
  }

  /**
   * Asks the hub who we are, without making the session live longer.
   *
   * @throws Unreachable
   */
  async refresh(): Promise<void> {
    this.setPerson(await this.api.currentPerson());
  }

  /** Tells the hub that the person is still here. @throws Unreachable */
  async extend(): Promise<void> {
    this.setPerson(await this.api.currentPerson(false));
  }

  /** @throws Refused, Unreachable */
  async login(name: string, password: string, code = ""): Promise<void> {
    const person = await this.api.login(name, password, code);
    this.notice = "";
    this.setPerson(person);
  }

  /** By a passkey: after name and password, or without both. @throws Refused, Unreachable */
  async loginByPasskey(name = "", password = ""): Promise<void> {
    const person = await this.api.loginByPasskey(await usePasskey(await this.api.passkeySignIn(name, password)));
    this.notice = "";
    this.setPerson(person);
  }

  /** Nobody is signed in afterwards, also when the hub could not be told. */
  async logout(): Promise<void> {
    this.going = true;
    this.notifyWatchers();
    try {
      await this.api.logout();
    } finally {
      this.going = false;
      this.notice = "";
      this.setPerson(null);
    }
  }

  /** Changes when somebody else is here, or the same person may do other things than before. */
  get rightsKey(): string {
    return rightsOf(this.someone);
  }

  private setPerson(person: Me | null): void {
    const same = this.asked && isSamePerson(person, this.someone);
    this.asked = true;
    this.someone = person;
    if (person === null) this.notes?.removeItem(NOTE);
    else this.notes?.setItem(NOTE, "1");
    if (!same) this.notifyWatchers();
  }
}

/** Watchers are told of everything but the idle time, which moves all the time. */
function isSamePerson(a: Me | null, b: Me | null): boolean {
  return rightsOf(a) === rightsOf(b) && a?.factor === b?.factor && a?.password === b?.password && a?.codes_locked_us === b?.codes_locked_us;
}

function rightsOf(person: Me | null): string {
  return person === null ? "" : JSON.stringify([person.name, person.role, person.admin, person.factor_missing, person.permissions]);
}
