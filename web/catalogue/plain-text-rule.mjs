/** An ESLint rule: what a person reads in a template goes through `msg()`, or it stays English. */

/** Attributes and properties that are read, or read aloud. */
const READ = /^\.?(aria-label|aria-description|aria-roledescription|aria-valuetext|title|placeholder|alt|label|heading|hint|summary|what|how|word|caption)$/;
/** Elements whose text is not for people, or is what they would type. */
const UNREAD = new Set(["style", "script", "code", "pre", "kbd", "samp"]);
/** Signs that are the same in each language: units, names of scales, what is written on a robot's messages. */
const SAME = new Set(
  "Talaia STOP UTC GMT RA Dec J2000 JD MJD FITS MCAP CSV YAML JSON URL IP QR ROS MQTT TLS mas mag min max std px fps kB MB GB ms dB km cm mm kg rad deg Hz kHz MHz".split(" "),
);
const HOLE = "\u0001";

function hasWords(text) {
  const words = text.replace(/&\w+;|&#\d+;|https?:\/\/\S+/g, " ").match(/\p{L}[\p{L}'’-]*/gu) ?? [];
  return words.some((word) => word.length > 1 && !SAME.has(word));
}

/** The bare texts of a template: of `html` its texts and the values of attributes that are read. */
export function plainTexts(strings) {
  const source = strings.join(HOLE);
  const found = [];
  const open = [];
  let at = 0;
  while (at < source.length) {
    if (source.startsWith("<!--", at)) {
      const end = source.indexOf("-->", at);
      at = end < 0 ? source.length : end + 3;
    } else if (/^<\/[a-z]/i.test(source.slice(at, at + 3))) {
      const end = source.indexOf(">", at);
      const tag = source.slice(at + 2, end).trim();
      if (open.includes(tag)) open.length = open.lastIndexOf(tag);
      at = end + 1;
    } else if (/^<[a-z]/i.test(source.slice(at, at + 2))) {
      const tag = /^<([\w-]+)/.exec(source.slice(at))[1];
      at += tag.length + 1;
      const attribute = /\s*([^\s=>"'/]+)(?:=(?:"([^"]*)"|'([^']*)'|([^\s>]*)))?|\s*\/?>|\s+/y;
      for (;;) {
        attribute.lastIndex = at;
        const match = attribute.exec(source);
        if (match === null) return found;
        at = attribute.lastIndex;
        if (match[0].trimEnd().endsWith(">") && match[1] === undefined) {
          if (!match[0].includes("/>")) open.push(tag);
          break;
        }
        const value = match[2] ?? match[3] ?? match[4] ?? "";
        if (match[1] !== undefined && READ.test(match[1]) && hasWords(value)) found.push(`${match[1]}="${value.replaceAll(HOLE, "…")}"`);
      }
    } else {
      const next = source.slice(at + 1).search(/<[a-z/!]/i);
      const end = next < 0 ? source.length : at + 1 + next;
      const text = source.slice(at, end);
      if (!open.some((tag) => UNREAD.has(tag)) && hasWords(text.replaceAll(HOLE, " "))) found.push(text.replaceAll(HOLE, "…").replace(/\s+/g, " ").trim());
      at = end;
    }
  }
  return found;
}

/** Whether a text of the code is a sentence that people read: it begins with a capital, and has three words or more. */
export function isSentence(text) {
  return /^[A-Z“]/.test(text) && !/[;{}<>=]/.test(text) && (text.match(/\p{L}{2,}/gu) ?? []).length >= 3 && / \p{Ll}+[ .,?!]/u.test(text);
}

/** What is given to these is said elsewhere, or to who writes the program. */
const SAID_ELSEWHERE = /^(msg|css|.*Error|MessageError|describe|test)$/;

function isSaidElsewhere(node) {
  for (let outer = node.parent; outer != null; outer = outer.parent) {
    if (outer.type === "CallExpression" || outer.type === "NewExpression") {
      const name = outer.callee.name ?? outer.callee.property?.name ?? "";
      if (SAID_ELSEWHERE.test(name)) return true;
    }
    if (outer.type === "TaggedTemplateExpression" && ["css", "str", "html", "svg"].includes(outer.tag.name)) return outer.tag.name !== "html" && outer.tag.name !== "svg";
    if (outer.type === "ImportDeclaration" || outer.type === "TSLiteralType") return true;
  }
  return false;
}

export default {
  rules: {
    "plain-sentence": {
      meta: { type: "problem", schema: [], messages: { plain: "“{{text}}” stays English: put it through msg() of @lit/localize." } },
      create: (context) => {
        const check = (node, text) => {
          if (isSentence(text) && !isSaidElsewhere(node)) context.report({ node, messageId: "plain", data: { text } });
        };
        return {
          Literal: (node) => typeof node.value === "string" && check(node, node.value),
          TemplateLiteral(node) {
            if (node.parent.type !== "TaggedTemplateExpression") check(node, node.quasis.map(({ value }) => value.cooked).join(" 0 "));
          },
        };
      },
    },
    "plain-text": {
      meta: { type: "problem", schema: [], messages: { plain: "“{{text}}” stays English: put it through msg() of @lit/localize." } },
      create: (context) => ({
        TaggedTemplateExpression(node) {
          if (node.tag.name !== "html" && node.tag.name !== "svg") return;
          if (node.parent.type === "CallExpression" && node.parent.callee.name === "msg") return;
          for (const text of plainTexts(node.quasi.quasis.map(({ value }) => value.raw))) context.report({ node, messageId: "plain", data: { text } });
        },
      }),
    },
  },
};
