/** The browser's passkeys (WebAuthn) in the words of the hub: JSON in, JSON out. */

import { msg, str } from "@lit/localize";
import { Refused } from "./hub-api.js";

type CredentialJson = Readonly<Record<string, unknown>>;

/** Whether this browser can have passkeys here: only in a secure context, and for a name. */
export function hasPasskeys(): boolean {
  return typeof PublicKeyCredential !== "undefined" && window.isSecureContext && !/^(\[.*\]|[\d.]+)$/.test(location.hostname);
}

/** Lets the browser make a passkey. @throws Refused when the person, or the browser, did not want to */
export async function createPasskey(options: CredentialJson): Promise<CredentialJson> {
  const publicKey = withBytes(options) as unknown as PublicKeyCredentialCreationOptions;
  return answerOf(await asked(() => navigator.credentials.create({ publicKey }), "made"));
}

/** Lets a passkey answer. @throws Refused when the person, or the browser, did not want to */
export async function usePasskey(options: CredentialJson): Promise<CredentialJson> {
  const publicKey = withBytes(options) as unknown as PublicKeyCredentialRequestOptions;
  return answerOf(await asked(() => navigator.credentials.get({ publicKey }), "used"));
}

async function asked(ask: () => Promise<Credential | null>, done: string): Promise<Credential | null> {
  try {
    return await ask();
  } catch (error) {
    const known = error instanceof DOMException && error.name === "InvalidStateError";
    // Browsers do not say more, so that pages cannot find out which keys somebody has.
    throw new Refused(400, "passkey", known ? msg("This device has a passkey for you already.") : msg(str`No passkey was ${done}: it was cancelled, or took too long.`));
  }
}

function answerOf(credential: Credential | null): CredentialJson {
  if (!(credential instanceof PublicKeyCredential)) throw new Refused(400, "passkey", msg("The browser gave no passkey."));
  const { response } = credential;
  const said: Record<string, string> = { clientDataJSON: toText(response.clientDataJSON) };
  if (response instanceof AuthenticatorAttestationResponse) said.attestationObject = toText(response.attestationObject);
  if (response instanceof AuthenticatorAssertionResponse) {
    said.authenticatorData = toText(response.authenticatorData);
    said.signature = toText(response.signature);
    if (response.userHandle !== null) said.userHandle = toText(response.userHandle);
  }
  return { id: credential.id, rawId: toText(credential.rawId), type: credential.type, response: said };
}

/** With bytes where the browser wants bytes: the challenge, and every id but the hub's. */
function withBytes(options: CredentialJson): CredentialJson {
  const known = (list: unknown): unknown =>
    Array.isArray(list) ? list.map((each: CredentialJson) => ({ ...each, id: toBytes(String(each.id)) })) : [];
  const made: Record<string, unknown> = { ...options, challenge: toBytes(String(options.challenge)) };
  if (options.allowCredentials !== undefined) made.allowCredentials = known(options.allowCredentials);
  if (options.excludeCredentials !== undefined) made.excludeCredentials = known(options.excludeCredentials);
  const user = options.user as CredentialJson | undefined;
  if (user !== undefined) made.user = { ...user, id: toBytes(String(user.id)) };
  return made;
}

/** Reads base64url. */
export function toBytes(text: string): Uint8Array {
  return Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (letter) => letter.charCodeAt(0));
}

/** Writes base64url, without padding. */
export function toText(bytes: ArrayBuffer): string {
  const letters = Array.from(new Uint8Array(bytes), (byte) => String.fromCharCode(byte)).join("");
  return btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}
